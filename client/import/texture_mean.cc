#include "client/import/texture_mean.h"

#include <stb/stb_image.h>

#include <array>
#include <cmath>
#include <memory>

#include "common/util/file.h"

namespace isolux {
namespace {

constexpr uint64_t kMostBytes = 1ULL << 30;  // the decoder counts in int

}  // namespace

double FromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Result<Rgb> LinearMean(const std::string& bytes, const std::string& name, Encoding encoding,
                       uint64_t most_pixels) {
  if (bytes.size() > kMostBytes) {
    return Error(StatusCode::kResourceExhausted, "{}: an image of {} bytes, more than {}", name,
                 bytes.size(), kMostBytes);
  }
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_info_from_memory(data, size, &width, &height, &channels) == 0 || width < 1 ||
      height < 1) {
    return Error(StatusCode::kInvalidArgument, "{}: not an image (PNG, JPG, TGA or BMP)", name);
  }
  const uint64_t pixels = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  if (pixels > most_pixels) {
    return Error(StatusCode::kResourceExhausted, "{}: {} x {} pixels, more than {}", name, width,
                 height, most_pixels);
  }
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> image(
      stbi_load_from_memory(data, size, &width, &height, &channels, 3), stbi_image_free);
  if (image == nullptr) {
    return Error(StatusCode::kInvalidArgument, "{}: damaged image", name);
  }
  std::array<std::array<uint64_t, 256>, 3> counts{};
  for (uint64_t i = 0; i < pixels; ++i) {
    for (int c = 0; c < 3; ++c) ++counts[c][image.get()[3 * i + c]];
  }
  Rgb mean(0.0);
  for (int c = 0; c < 3; ++c) {
    for (int value = 0; value < 256; ++value) {
      const double code = value / 255.0;
      mean[c] += static_cast<double>(counts[c][value]) *
                 (encoding == Encoding::kSrgb ? FromSrgb(code) : code);
    }
    mean[c] /= static_cast<double>(pixels);
  }
  return mean;
}

Result<Rgb> LinearMean(const std::string& path, uint64_t most_pixels) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path, kMostBytes));
  return LinearMean(bytes, path, Encoding::kSrgb, most_pixels);
}

}  // namespace isolux
