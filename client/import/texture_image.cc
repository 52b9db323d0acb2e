#include "client/import/texture_image.h"

#include <stb/stb_image.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace isolux {
namespace {

constexpr uint64_t kMostTextureBytes = 1ULL << 30;  // the decoder counts in int

std::array<double, 256> CodesOf(Encoding encoding) {
  std::array<double, 256> values;
  for (size_t code = 0; code < values.size(); ++code) {
    const double value = static_cast<double>(code) / 255;
    values[code] = encoding == Encoding::kSrgb ? FromSrgb(value) : value;
  }
  return values;
}

// Which of `to` equal parts of a line pixel `i` of `from` lies in, and with what share of each.
struct Shares {
  uint32_t part = 0;
  double first = 1, second = 0;  // of part, and of the next
};

Shares SharesOf(uint32_t i, uint32_t from, uint32_t to) {
  const uint64_t start = static_cast<uint64_t>(i) * to;
  const uint64_t end = start + to;
  const auto part = static_cast<uint32_t>(start / from);
  const uint64_t border = static_cast<uint64_t>(part + 1) * from;
  if (end <= border) return {part, 1, 0};
  const double second = static_cast<double>(end - border) / to;
  return {part, 1 - second, second};
}

LinearImage AverageDown(const stbi_uc* pixels, uint32_t width, uint32_t height, Encoding encoding,
                        uint32_t most_side) {
  LinearImage image{std::min(width, most_side), std::min(height, most_side), {}};
  const std::array<double, 256> value = CodesOf(encoding);
  std::vector<double> sums(3ULL * image.width * image.height, 0.0);
  const auto add = [&](uint32_t x, uint32_t y, double share, const stbi_uc* pixel) {
    if (share == 0) return;
    double* sum = &sums[3 * (static_cast<size_t>(y) * image.width + x)];
    for (int c = 0; c < 3; ++c) sum[c] += share * value[pixel[c]];
  };
  for (uint32_t y = 0; y < height; ++y) {
    const Shares rows = SharesOf(y, height, image.height);
    for (uint32_t x = 0; x < width; ++x) {
      const stbi_uc* pixel = pixels + 3 * (static_cast<size_t>(y) * width + x);
      const Shares columns = SharesOf(x, width, image.width);
      add(columns.part, rows.part, rows.first * columns.first, pixel);
      add(columns.part + 1, rows.part, rows.first * columns.second, pixel);
      add(columns.part, rows.part + 1, rows.second * columns.first, pixel);
      add(columns.part + 1, rows.part + 1, rows.second * columns.second, pixel);
    }
  }
  const double pixels_a_texel =
      static_cast<double>(width) / image.width * (static_cast<double>(height) / image.height);
  for (double& sum : sums) sum /= pixels_a_texel;
  image.texels = std::move(sums);
  return image;
}

}  // namespace

double FromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Rgb LinearImage::Mean() const {
  Rgb sum(0.0);
  for (size_t i = 0; i < texels.size(); i += 3) {
    sum += Rgb(texels[i], texels[i + 1], texels[i + 2]);
  }
  return sum / (static_cast<double>(width) * height);
}

Result<LinearImage> DecodeImage(const std::string& bytes, const std::string& name,
                                Encoding encoding, uint32_t most_side, uint64_t most_pixels) {
  if (bytes.size() > kMostTextureBytes) {
    return Error(StatusCode::kResourceExhausted, "{}: an image of {} bytes, more than {}", name,
                 bytes.size(), kMostTextureBytes);
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
  if (static_cast<uint64_t>(width) * static_cast<uint64_t>(height) > most_pixels) {
    return Error(StatusCode::kResourceExhausted, "{}: {} x {} pixels, more than {}", name, width,
                 height, most_pixels);
  }
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> image(
      stbi_load_from_memory(data, size, &width, &height, &channels, 3), stbi_image_free);
  if (image == nullptr) {
    return Error(StatusCode::kInvalidArgument, "{}: damaged image", name);
  }
  return AverageDown(image.get(), static_cast<uint32_t>(width), static_cast<uint32_t>(height),
                     encoding, most_side);
}

}  // namespace isolux
