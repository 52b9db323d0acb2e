#include "client/import/sky_file.h"

#include <functional>
#include <numbers>

#include "client/import/gltf_document.h"
#include "client/import/radiance_image.h"

namespace isolux {
namespace {

constexpr uint32_t kModelRows = 128, kModelColumns = 256;
constexpr uint32_t kMostMapColumns = 1024, kMostMapRows = 512;

// Where the middle of maps and suns lie.
Status SetAxes(const JsonElement& element, Sky* sky) {
  sky->up = {0, 1, 0};
  if (element.json.contains("up")) {
    ASSIGN_OR_RETURN(sky->up, element.Direction("up"));
  }
  Vec3 ahead = std::abs(sky->up.z) < 0.9 ? Vec3(0, 0, -1) : Vec3(0, 1, 0);
  if (element.json.contains("ahead")) {
    ASSIGN_OR_RETURN(ahead, element.Direction("ahead"));
  }
  ahead -= glm::dot(ahead, sky->up) * sky->up;
  if (!(glm::length(ahead) > 1e-6)) {
    return element.Error("\"ahead\" is along \"up\"; choose another");
  }
  sky->ahead = glm::normalize(ahead);
  return {};
}

// Fills the texels above the horizon by what `radiance` says of the sine of the height and of the
// direction, those below with the ground's.
void Fill(uint32_t columns, uint32_t rows, const Rgb& ground,
          const std::function<Rgb(double sine, const Vec3& direction)>& radiance, Sky* sky) {
  sky->columns = columns;
  sky->rows = rows;
  for (uint32_t row = 0; row < rows; ++row) {
    const double sine = 1 - (2.0 * row + 1) / rows;
    for (uint32_t column = 0; column < columns; ++column) {
      const double turn = 2 * std::numbers::pi * (column + 0.5) / columns;
      const double level = std::sqrt(1 - sine * sine);
      const Vec3 direction = sine * sky->up + level * std::cos(turn) * sky->ahead +
                             level * std::sin(turn) * glm::cross(sky->up, sky->ahead);
      const Rgb texel = sine > 0 ? radiance(sine, direction) : ground;
      for (int c = 0; c < 3; ++c) sky->texels.push_back(static_cast<float>(texel[c]));
    }
  }
}

// Radiance over that of the zenith, without clouds ([CIE110], Kittler's formula): by the sine of
// the height, the angle from the sun and the sun's own from the zenith.
double ClearSky(double sine, double from_sun, double sun_from_zenith) {
  const auto scattered = [](double angle) {
    const double cosine = std::cos(angle);
    return 0.91 + 10 * std::exp(-3 * angle) + 0.45 * cosine * cosine;
  };
  const double depth = 1 - std::exp(-0.32 / std::max(sine, 1e-3));
  const double depth_at_zenith = 1 - std::exp(-0.32);
  return scattered(from_sun) * depth / (scattered(sun_from_zenith) * depth_at_zenith);
}

Status ReadModel(const JsonElement& element, const std::string& type, Sky* sky) {
  ASSIGN_OR_RETURN(const Rgb ground, element.Colour("ground", Rgb(0.0)));
  if (type == "constant") {
    RETURN_IF_ERROR(element.CheckKeys({"type", "up", "radiance", "ground"}));
    ASSIGN_OR_RETURN(const Rgb radiance, element.Colour("radiance"));
    const bool even = radiance == ground;
    Fill(
        1, even ? 1 : 2, ground, [&](double, const Vec3&) { return radiance; }, sky);
  } else if (type == "gradient") {
    RETURN_IF_ERROR(element.CheckKeys({"type", "up", "zenith", "horizon", "ground"}));
    ASSIGN_OR_RETURN(const Rgb zenith, element.Colour("zenith"));
    ASSIGN_OR_RETURN(const Rgb horizon, element.Colour("horizon"));
    const auto radiance = [&](double sine, const Vec3&) {
      return sine * zenith + (1 - sine) * horizon;
    };
    Fill(1, kModelRows, ground, radiance, sky);
  } else if (type == "cie_overcast") {
    RETURN_IF_ERROR(element.CheckKeys({"type", "up", "zenith", "ground"}));
    ASSIGN_OR_RETURN(const Rgb zenith, element.Colour("zenith"));
    const auto radiance = [&](double sine, const Vec3&) { return (1 + 2 * sine) / 3 * zenith; };
    Fill(1, kModelRows, ground, radiance, sky);
  } else {  // cie_clear
    RETURN_IF_ERROR(element.CheckKeys({"type", "up", "zenith", "sun", "ground"}));
    ASSIGN_OR_RETURN(const Rgb zenith, element.Colour("zenith"));
    ASSIGN_OR_RETURN(const Vec3 sun, element.Direction("sun"));
    const double height = glm::dot(sun, sky->up);
    if (!(height > 0)) return element.Error("\"sun\" must point above the horizon");
    const auto radiance = [&](double sine, const Vec3& direction) {
      const double cosine = std::clamp(glm::dot(direction, sun), -1.0, 1.0);
      return ClearSky(sine, std::acos(cosine), std::acos(std::min(height, 1.0))) * zenith;
    };
    Fill(kModelColumns, kModelRows, ground, radiance, sky);
  }
  return {};
}

Status ReadMap(const JsonElement& element, const std::string& folder, Sky* sky) {
  RETURN_IF_ERROR(element.CheckKeys({"type", "up", "ahead", "file", "scale"}));
  ASSIGN_OR_RETURN(const std::string file, element.Text("file"));
  ASSIGN_OR_RETURN(const Rgb scale, element.Colour("scale", Rgb(1.0)));
  const Result<std::string> path = ResolveInside(folder, file);
  if (!path.has_value()) return path.error().Within(element.where);
  ASSIGN_OR_RETURN(const RadianceImage image, ReadRadianceImage(*path));
  Sky map = FromEquirectangular(image.pixels, image.width, image.height);
  for (size_t i = 0; i < map.texels.size(); ++i) map.texels[i] *= static_cast<float>(scale[i % 3]);
  map.up = sky->up;
  map.ahead = sky->ahead;
  *sky = std::move(map);
  return {};
}

// Adds an amount spread evenly over [begin, end) of a line to its unit cells.
template <typename Add>
void Spread(double begin, double end, uint32_t cells, const Add& add) {
  for (auto cell = static_cast<uint32_t>(std::max(begin, 0.0)); cell < cells && cell < end;
       ++cell) {
    const double part = std::min(end, cell + 1.0) - std::max(begin, static_cast<double>(cell));
    if (part > 0) add(cell, part / (end - begin));
  }
}

}  // namespace

// Every pixel has its solid angle, which it shares out to the texels it overlaps.
Sky FromEquirectangular(const std::vector<float>& pixels, uint32_t width, uint32_t height) {
  Sky sky;
  sky.columns = std::min(width, kMostMapColumns);
  sky.rows = std::clamp(height / 2, 1U, kMostMapRows);
  std::vector<double> sums(3ULL * sky.columns * sky.rows, 0.0);
  const auto row_of = [&](uint32_t y) {  // of the upper side of a row of pixels
    return 0.5 * (1 - std::cos(std::numbers::pi * y / height)) * sky.rows;
  };
  for (uint32_t y = 0; y < height; ++y) {
    const double high = row_of(y), low = row_of(y + 1);
    Spread(high, low, sky.rows, [&](uint32_t row, double row_share) {
      for (uint32_t x = 0; x < width; ++x) {
        // Columns turn left from the middle of the image.
        const double left = 0.5 - static_cast<double>(x + 1) / width;
        const double begin = (left < 0 ? left + 1 : left) * sky.columns;
        const double end = begin + static_cast<double>(sky.columns) / width;
        Spread(begin, end, 2 * sky.columns, [&](uint32_t column, double share) {
          const double weight =
              share * row_share * (low - high) * static_cast<double>(sky.columns) / width;
          const size_t to = 3 * (static_cast<size_t>(row) * sky.columns + column % sky.columns);
          const size_t from = 3 * (static_cast<size_t>(y) * width + x);
          for (size_t c = 0; c < 3; ++c) sums[to + c] += weight * pixels[from + c];
        });
      }
    });
  }
  sky.texels.assign(sums.begin(), sums.end());
  return sky;
}

Result<Sky> ReadSky(const JsonElement& element, const std::string& folder) {
  if (!element.json.is_object()) return element.Error("not an object; write {{…}}");
  const Result<std::string> type = element.Text("type");
  Sky sky;
  RETURN_IF_ERROR(SetAxes(element, &sky));
  if (type.has_value()) sky.name = *type;
  if (sky.name == "map") {
    RETURN_IF_ERROR(ReadMap(element, folder, &sky));
  } else if (sky.name == "constant" || sky.name == "gradient" || sky.name == "cie_overcast" ||
             sky.name == "cie_clear") {
    RETURN_IF_ERROR(ReadModel(element, sky.name, &sky));
  } else {
    return element.Error(
        "\"type\" must be one of \"constant\", \"gradient\", \"cie_overcast\", \"cie_clear\", "
        "\"map\"");
  }
  sky.name = *type;
  RETURN_IF_ERROR(CheckSky(sky).Within(element.where));
  return sky;
}

}  // namespace isolux
