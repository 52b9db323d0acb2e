// Little-endian numbers into a string of bytes and out of one. The reader never looks past the end:
// a read that does not fit gives zeros and leaves the reader failed, so that a decoder may check
// once after each group of fields; counts are checked against what is left before memory is taken.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace isolux {

static_assert(std::endian::native == std::endian::little,
              "the formats are written by copying memory");

class ByteWriter {
 public:
  explicit ByteWriter(size_t expected_bytes = 0) { bytes_.reserve(expected_bytes); }

  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void PutBytes(std::string_view bytes) { bytes_.append(bytes); }
  // Length as u32, then the bytes.
  void PutText(std::string_view text) {
    Put(static_cast<uint32_t>(text.size()));
    PutBytes(text);
  }

  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class ByteReader {
 public:
  // `bytes` must outlive the reader.
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  template <typename T>
  T Get() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    const std::string_view bytes = GetBytes(sizeof value);
    if (ok_) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  // Empty, and the reader failed, where fewer are left.
  std::string_view GetBytes(uint64_t count) {
    if (!ok_ || count > rest_.size()) {
      ok_ = false;
      return {};
    }
    const std::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }
  std::string_view GetText(uint32_t longest) {
    const auto length = Get<uint32_t>();
    if (length > longest) ok_ = false;
    return GetBytes(length);
  }
  // Whether `count` items of `item_bytes` each can still be read; otherwise the reader fails.
  bool Holds(uint64_t count, uint64_t item_bytes) {
    if (item_bytes > 0 && count > rest_.size() / item_bytes) ok_ = false;
    return ok_;
  }

  bool ok() const { return ok_; }
  uint64_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace isolux
