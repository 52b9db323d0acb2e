#include "common/scene/glazing.h"

#include <algorithm>
#include <cmath>

#include "common/scene/medium.h"

namespace isolux {
namespace {

// At more grazing angles nothing is left.
constexpr double kLeastCosine = 1e-9;

struct Interface {
  double across = 0, along = 0;  // reflectances of the two polarizations
  double inside = 1;             // cosine within the glass
};

Interface InterfaceAt(double index, double cosine) {
  Interface result;
  result.inside =
      std::sqrt(std::max(0.0, 1 - std::max(0.0, 1 - cosine * cosine) / (index * index)));
  if (index == 1) return result;
  const double s = (cosine - index * result.inside) / (cosine + index * result.inside);
  const double p = (index * cosine - result.inside) / (index * cosine + result.inside);
  result.across = s * s;
  result.along = p * p;
  return result;
}

double Passes(double r, double t) { return (1 - r) * (1 - r) * t / ((1 - r * t) * (1 + r * t)); }

double TurnsBack(double r, double t) {
  return r + r * (1 - r) * (1 - r) * t * t / ((1 - r * t) * (1 + r * t));
}

template <typename Of>
Rgb BothPolarizations(const Glass& glass, double cosine, const Of& of) {
  const Interface at = InterfaceAt(glass.index, cosine);
  Rgb result;
  for (int c = 0; c < 3; ++c) {
    if (c > 0 && glass.optical_depth[c] == glass.optical_depth[c - 1]) {
      result[c] = result[c - 1];
      continue;
    }
    const double depth = glass.optical_depth[c];
    const double t = depth == 0 ? 1.0 : ExpOfMinus(depth / std::max(at.inside, kLeastCosine));
    result[c] = 0.5 * (of(at.across, t) + of(at.along, t));
  }
  return result;
}

// Over the hemisphere: midpoints of equal parts of the squared sine.
template <typename Of>
Rgb Mean(const Of& of) {
  constexpr int kParts = 512;
  Rgb sum(0.0);
  for (int i = 0; i < kParts; ++i) sum += of(std::sqrt((i + 0.5) / kParts));
  return sum / static_cast<double>(kParts);
}

}  // namespace

Rgb Glass::Transmittance(double cosine) const {
  if (!(cosine > kLeastCosine)) return Rgb(0.0);
  return BothPolarizations(*this, std::min(cosine, 1.0), Passes);
}

Rgb Glass::Reflectance(double cosine) const {
  if (index == 1) return Rgb(0.0);
  if (!(cosine > kLeastCosine)) return Rgb(1.0);
  return BothPolarizations(*this, std::min(cosine, 1.0), TurnsBack);
}

Rgb Glass::MeanTransmittance() const {
  return Mean([this](double cosine) { return Transmittance(cosine); });
}

Rgb Glass::MeanReflectance() const {
  return Mean([this](double cosine) { return Reflectance(cosine); });
}

double OpticalDepthOf(double share) {
  if (!(share > 0)) return kLargestOpticalDepth;
  return share >= 1 ? 0.0 : std::min(kLargestOpticalDepth, -std::log(share));
}

bool Glazing::is_grey() const { return std::ranges::all_of(glasses, &Glass::is_grey); }

Status CheckGlazing(const Glazing& glazing, uint64_t most_panes) {
  const auto fail = [](size_t number, const char* what) {
    return MakeStatus(StatusCode::kInvalidArgument, "glass {}: {}", number, what);
  };
  for (size_t g = 0; g < glazing.glasses.size(); ++g) {
    const Glass& glass = glazing.glasses[g];
    for (int c = 0; c < 3; ++c) {
      const double depth = glass.optical_depth[c];
      if (!(depth >= 0 && depth <= kLargestOpticalDepth)) {
        return fail(g, "its inside leaves more light than enters; lower Tf to 1 or less");
      }
    }
    if (!(glass.index >= 1 && glass.index <= kLargestIndex)) {
      return fail(g, "an index of refraction outside 1 to 5; correct Ni");
    }
  }
  if (glazing.panes.size() > most_panes) {
    return MakeStatus(StatusCode::kResourceExhausted,
                      "the scene has {} panes of glass, more than the limit of {}; leave some out",
                      glazing.panes.size(), most_panes);
  }
  for (size_t p = 0; p < glazing.panes.size(); ++p) {
    const Pane& pane = glazing.panes[p];
    bool right = (pane.count == 3 || pane.count == 4) && pane.glass < glazing.glasses.size();
    for (uint32_t i = 0; right && i < pane.count; ++i) {
      const Vec3& v = pane.corners[i];
      right = std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    }
    if (!right) return MakeStatus(StatusCode::kInvalidArgument, "pane {}: it is no polygon", p);
  }
  return {};
}

void PutGlazing(ByteWriter& out, const Glazing& glazing) {
  if (!glazing.exists()) return;
  const auto put = [&](const Vec3& v) {
    for (int c = 0; c < 3; ++c) out.Put(v[c]);
  };
  out.Put(kGlazingMagic);
  out.Put(static_cast<uint64_t>(glazing.glasses.size()));
  out.Put(static_cast<uint64_t>(glazing.panes.size()));
  for (const Glass& glass : glazing.glasses) {
    put(glass.optical_depth);
    out.Put(glass.index);
  }
  for (const Pane& pane : glazing.panes) {
    for (const Vec3& corner : pane.corners) put(corner);
    out.Put(pane.count);
    out.Put(pane.glass);
    out.Put(static_cast<uint8_t>(pane.is_half ? 1 : 0));
  }
}

Status TakeGlazing(ByteReader& in, uint64_t most_panes, Glazing* glazing) {
  constexpr uint64_t kGlassBytes = 4 * sizeof(double);
  constexpr uint64_t kPaneBytes = 12 * sizeof(double) + 2 * sizeof(uint32_t) + 1;
  in.Get<uint64_t>();
  const auto glasses = in.Get<uint64_t>();
  const auto panes = in.Get<uint64_t>();
  if (!in.Holds(glasses, kGlassBytes) || !in.Holds(panes, kPaneBytes) || panes == 0) {
    return MakeStatus(StatusCode::kDataLoss, "scene: its panes of glass are missing");
  }
  const auto take = [&] {
    Vec3 v;
    for (int c = 0; c < 3; ++c) v[c] = in.Get<double>();
    return v;
  };
  for (uint64_t g = 0; g < glasses && in.ok(); ++g) {
    Glass& glass = glazing->glasses.emplace_back();
    glass.optical_depth = take();
    glass.index = in.Get<double>();
  }
  for (uint64_t p = 0; p < panes && in.ok(); ++p) {
    Pane& pane = glazing->panes.emplace_back();
    for (Vec3& corner : pane.corners) corner = take();
    pane.count = in.Get<uint32_t>();
    pane.glass = in.Get<uint32_t>();
    pane.is_half = in.Get<uint8_t>() != 0;
  }
  if (!in.ok()) return MakeStatus(StatusCode::kDataLoss, "scene: its panes of glass are missing");
  return CheckGlazing(*glazing, most_panes);
}

}  // namespace isolux
