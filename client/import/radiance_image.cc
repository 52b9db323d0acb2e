#include "client/import/radiance_image.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <stb/stb_image.h>

#include <cmath>
#include <memory>

#include "common/util/file.h"

namespace isolux {
namespace {

constexpr uint64_t kMostImageBytes = 1ULL << 30;

Status CheckSize(const std::string& path, int64_t width, int64_t height, uint64_t most_pixels) {
  if (width > 0 && height > 0 &&
      static_cast<uint64_t>(width) <= most_pixels / static_cast<uint64_t>(height)) {
    return {};
  }
  return MakeStatus(StatusCode::kResourceExhausted,
                    "{}: {} x {} pixels; it must have from 1 to {}, make it smaller", path, width,
                    height, most_pixels);
}

Result<RadianceImage> ReadHdr(const std::string& path, const std::string& bytes,
                              uint64_t most_pixels) {
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (stbi_is_hdr_from_memory(data, size) == 0 ||
      stbi_info_from_memory(data, size, &width, &height, &channels) == 0) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: neither a Radiance (.hdr) nor an OpenEXR image; convert it", path);
  }
  RETURN_IF_ERROR(CheckSize(path, width, height, most_pixels));
  const std::unique_ptr<float, decltype(&stbi_image_free)> pixels(
      stbi_loadf_from_memory(data, size, &width, &height, &channels, 3), stbi_image_free);
  if (pixels == nullptr) return Error(StatusCode::kInvalidArgument, "{}: damaged image", path);
  const size_t count = 3ULL * static_cast<size_t>(width) * static_cast<size_t>(height);
  return RadianceImage{static_cast<uint32_t>(width), static_cast<uint32_t>(height),
                       std::vector<float>(pixels.get(), pixels.get() + count)};
}

Result<RadianceImage> ReadExr(const std::string& path, uint64_t most_pixels) {
  try {  // the library throws
    Imf::InputFile file(path.c_str(), 1);
    const Imath::Box2i window = file.header().dataWindow();
    const int64_t width = static_cast<int64_t>(window.max.x) - window.min.x + 1;
    const int64_t height = static_cast<int64_t>(window.max.y) - window.min.y + 1;
    RETURN_IF_ERROR(CheckSize(path, width, height, most_pixels));
    for (const char* channel : {"R", "G", "B"}) {
      if (file.header().channels().findChannel(channel) == nullptr) {
        return Error(StatusCode::kInvalidArgument, "{}: it has no channel {}; convert it to RGB",
                     path, channel);
      }
    }
    RadianceImage image{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
    image.pixels.resize(3ULL * image.width * image.height);
    Imf::FrameBuffer buffer;
    const size_t pixel = 3 * sizeof(float);
    int channel = 0;
    for (const char* name : {"R", "G", "B"}) {
      buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, image.pixels.data() + channel++, window,
                                           pixel, pixel * image.width));
    }
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    return image;
  } catch (const std::exception& exception) {
    return Error(StatusCode::kInvalidArgument, "{}: damaged OpenEXR image: {}", path,
                 exception.what());
  }
}

}  // namespace

Result<RadianceImage> ReadRadianceImage(const std::string& path, uint64_t most_pixels) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path, kMostImageBytes));
  const bool exr = bytes.starts_with("\x76\x2f\x31\x01");
  ASSIGN_OR_RETURN(RadianceImage image,
                   exr ? ReadExr(path, most_pixels) : ReadHdr(path, bytes, most_pixels));
  for (float& value : image.pixels) {
    if (!std::isfinite(value)) {
      return Error(StatusCode::kInvalidArgument, "{}: a pixel is not a number; mend the image",
                   path);
    }
    value = std::max(value, 0.0F);  // resampling leaves some below
  }
  return image;
}

}  // namespace isolux
