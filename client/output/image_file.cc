#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <png.h>

#include <algorithm>
#include <cstring>
#include <exception>

#include "client/output/picture.h"
#include "common/util/file.h"

namespace isolux {
namespace {

// What OpenEXR writes, kept in memory.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : Imf::OStream("memory") {}
  void write(const char bytes[], int count) override {
    const size_t end = place_ + static_cast<size_t>(count);
    if (bytes_.size() < end) bytes_.resize(end);
    std::memcpy(bytes_.data() + place_, bytes, static_cast<size_t>(count));
    place_ = end;
  }
  uint64_t tellp() override { return place_; }
  void seekp(uint64_t place) override { place_ = place; }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  size_t place_ = 0;
};

}  // namespace

Result<std::string> EncodePng(int width, int height, const std::vector<uint8_t>& rgb) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0) {
    return Error(StatusCode::kInternal, "the picture cannot be encoded: {}", image.message);
  }
  bytes.resize(size);
  return bytes;
}

Status WritePng(const std::string& path, int width, int height, const std::vector<uint8_t>& rgb) {
  const auto bytes = EncodePng(width, height, rgb);
  return bytes ? WriteFileDurably(path, *bytes) : bytes.error().Within(path);
}

Status WriteExr(const std::string& path, const Image& image) {
  MemoryStream stream;
  try {
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::addComments(header, "radiance, W/(m2 sr), linear");
    Imf::FrameBuffer frame;
    constexpr const char* kNames[] = {"R", "G", "B"};
    char* base = const_cast<char*>(reinterpret_cast<const char*>(image.rgb.data()));
    for (size_t c = 0; c < 3; ++c) {
      header.channels().insert(kNames[c], Imf::Channel(Imf::FLOAT));
      frame.insert(kNames[c], Imf::Slice(Imf::FLOAT, base + c * sizeof(float), 3 * sizeof(float),
                                         3 * sizeof(float) * static_cast<size_t>(image.width)));
    }
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(frame);
    file.writePixels(image.height);
  } catch (const std::exception& error) {
    return MakeStatus(StatusCode::kInternal, "{}: cannot be encoded: {}", path, error.what());
  }
  return WriteFileDurably(path, stream.bytes());
}

}  // namespace isolux
