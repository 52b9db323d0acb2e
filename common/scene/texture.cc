#include "common/scene/texture.h"

#include <algorithm>
#include <cmath>

namespace isolux {
namespace {

// The place in an image of `size` texels of one beyond its borders.
int64_t Wrapped(int64_t i, int64_t size, Wrap wrap) {
  if (wrap == Wrap::kClamp) return std::clamp<int64_t>(i, 0, size - 1);
  const int64_t period = wrap == Wrap::kMirror ? 2 * size : size;
  const int64_t place = ((i % period) + period) % period;
  return place < size ? place : period - 1 - place;
}

}  // namespace

TextureIntegral::TextureIntegral(const Texture& texture)
    : width_(texture.width),
      height_(texture.height),
      wrap_u_(texture.wrap_u),
      wrap_v_(texture.wrap_v),
      before_(static_cast<size_t>(width_ + 1) * height_) {
  size_t texel = 0;
  for (size_t row = 0; row < height_; ++row) {
    Sums sum{};
    for (size_t x = 0; x <= width_; ++x) {
      before_[row * (width_ + 1) + x] = sum;
      if (x == width_) break;
      for (size_t c = 0; c < 3; ++c) {
        const double value = texture.texels[texel++];
        sum[c] += value;
        sum[3 + c] += value * value;
      }
    }
  }
}

int64_t TextureIntegral::Row(int64_t y) const { return Wrapped(y, height_, wrap_v_); }

TextureIntegral::Sums TextureIntegral::Within(int64_t row, double x) const {
  const auto column = std::min<int64_t>(static_cast<int64_t>(x), width_ - 1);
  const Sums& low = before_[row * (width_ + 1) + column];
  const Sums& high = before_[row * (width_ + 1) + column + 1];
  Sums result;
  for (size_t k = 0; k < result.size(); ++k) {
    result[k] = low[k] + (x - static_cast<double>(column)) * (high[k] - low[k]);
  }
  return result;
}

TextureIntegral::Sums TextureIntegral::Along(int64_t row, double x) const {
  const double size = width_;
  const Sums& whole = before_[row * (width_ + 1) + width_];
  // times · whole + Within(inside) · sign
  double times = 0, inside = 0, sign = 1;
  if (wrap_u_ == Wrap::kClamp) {
    inside = std::clamp(x, 0.0, size);
  } else if (wrap_u_ == Wrap::kRepeat) {
    times = std::floor(x / size);
    inside = std::clamp(x - times * size, 0.0, size);
  } else {
    times = 2 * std::floor(x / (2 * size));
    inside = std::clamp(x - times * size, 0.0, 2 * size);
    if (inside > size) {
      times += 2;
      inside = 2 * size - inside;
      sign = -1;
    }
  }
  Sums result = Within(row, inside);
  for (size_t k = 0; k < result.size(); ++k) result[k] = times * whole[k] + sign * result[k];
  if (inside != x && wrap_u_ == Wrap::kClamp) {  // the border's texel goes on
    const size_t border = row * (width_ + 1) + (x < 0 ? 0 : width_ - 1);
    for (size_t k = 0; k < result.size(); ++k) {
      result[k] += (x - inside) * (before_[border + 1][k] - before_[border][k]);
    }
  }
  return result;
}

TextureIntegral::Sums TextureIntegral::TexelAt(const TexturePoint& p) const {
  const auto column = Wrapped(static_cast<int64_t>(std::floor(p.x)), width_, wrap_u_);
  const size_t at = Row(static_cast<int64_t>(std::floor(p.y))) * (width_ + 1) + column;
  Sums result;
  for (size_t k = 0; k < result.size(); ++k) result[k] = before_[at + 1][k] - before_[at][k];
  return result;
}

TextureMoments TextureIntegral::Over(std::span<const TexturePoint> polygon) const {
  TexturePoint low = polygon[0], high = polygon[0], middle;
  for (const TexturePoint& p : polygon) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    middle.x += p.x / static_cast<double>(polygon.size());
    middle.y += p.y / static_cast<double>(polygon.size());
  }
  const auto moments = [](const Sums& s) {
    return TextureMoments{{s[0], s[1], s[2]}, {s[3], s[4], s[5]}};
  };
  if (std::floor(low.x) == std::floor(high.x) && std::floor(low.y) == std::floor(high.y)) {
    return moments(TexelAt(middle));
  }
  double area = 0;
  Sums sum{};
  for (size_t i = 0; i < polygon.size(); ++i) {
    const TexturePoint &from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
    const double dx = to.x - from.x, dy = to.y - from.y;
    if (dy == 0) continue;
    // Shares of the side at which it next crosses a border of texels, both ways.
    double line_x = dx > 0 ? std::floor(from.x) + 1 : std::ceil(from.x) - 1;
    double line_y = dy > 0 ? std::floor(from.y) + 1 : std::ceil(from.y) - 1;
    for (double t = 0; t < 1;) {
      const double at_x = dx == 0 ? 2 : (line_x - from.x) / dx;
      const double at_y = (line_y - from.y) / dy;
      const double next = std::max(t, std::min({at_x, at_y, 1.0}));
      if (at_x <= next) line_x += dx > 0 ? 1 : -1;
      if (at_y <= next) line_y += dy > 0 ? 1 : -1;
      const double x = from.x + 0.5 * (t + next) * dx, y = from.y + 0.5 * (t + next) * dy;
      const double step = (next - t) * dy;
      t = next;
      if (step == 0) continue;
      const int64_t row = Row(static_cast<int64_t>(std::floor(y)));
      const Sums here = Along(row, x), start = Along(row, low.x);
      area += step * (x - low.x);
      for (size_t k = 0; k < sum.size(); ++k) sum[k] += step * (here[k] - start[k]);
    }
  }
  // Far below what a sliver that was made wide enough spans, far above rounding.
  if (std::abs(area) <= 1e-13 * (1 + high.x - low.x) * (1 + high.y - low.y)) {
    return moments(TexelAt(middle));
  }
  for (double& s : sum) s /= area;
  return moments(sum);
}

Rgb LargestTexel(const Texture& texture) {
  Rgb largest(0.0);
  for (size_t i = 0; i < texture.texels.size(); ++i) {
    double& most = largest[static_cast<int>(i % 3)];
    most = std::max(most, static_cast<double>(texture.texels[i]));
  }
  return largest;
}

Status CheckTexture(const Texture& texture) {
  const uint64_t count = static_cast<uint64_t>(texture.width) * texture.height;
  if (count == 0 || count > Texture::kMostTexels || texture.texels.size() != 3 * count) {
    return MakeStatus(StatusCode::kInvalidArgument, "{} x {} texels with {} values; at most {}",
                      texture.width, texture.height, texture.texels.size(), Texture::kMostTexels);
  }
  if (texture.wrap_u > Wrap::kMirror || texture.wrap_v > Wrap::kMirror) {
    return MakeStatus(StatusCode::kInvalidArgument, "unknown wrap mode");
  }
  // The mean is 1, so no texel is above their number.
  const auto most = static_cast<float>(1.01 * static_cast<double>(count));
  for (const float value : texture.texels) {
    if (value >= 0 && value <= most) continue;
    return MakeStatus(StatusCode::kInvalidArgument, "texel {} is no share of a mean", value);
  }
  return {};
}

}  // namespace isolux
