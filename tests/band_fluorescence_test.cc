// Fluorescence between spectral bands through whole solves: against closed forms of furnaces and a
// full matrix with exact couplings, within a group of bands and from one to the next; energy, the
// bound, and the same bits on any number of workers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/hierarchy/effects/plan.h"
#include "server/band_solve.h"
#include "tests/support/dense_transport.h"
#include "tests/support/local_cluster.h"
#include "tests/support/same_bits.h"
#include "tests/support/scenes.h"
#include "tests/support/sheet.h"
#include "tests/support/solve_scene.h"
#include "worker/radiosity/solver.h"

namespace isolux::testing {
namespace {

std::vector<Band> EvenBands(size_t count) {
  std::vector<Band> bands;
  const auto edge_nm = [&](size_t b) {
    return 400 + 300.0 * static_cast<double>(b) / static_cast<double>(count);
  };
  for (size_t b = 0; b < count; ++b) bands.push_back({edge_nm(b), edge_nm(b + 1)});
  return bands;
}

struct Share {
  size_t from, to;
  double share;
};

BandReradiation Matrix(size_t bands, const std::vector<Share>& shares) {
  BandReradiation matrix{bands, std::vector<double>(bands * bands, 0.0)};
  for (const Share& s : shares) matrix.shares[bands * s.from + s.to] = s.share;
  return matrix;
}

// What red, green and blue are of the spectra, as files have it.
void SetChannels(Scene& scene) {
  for (Material& material : scene.materials) {
    const Spectrum& spectrum = material.spectrum;
    for (int c = 0; c < 3; ++c) {
      if (!spectrum.reflectance.empty()) {
        material.reflectance[c] = MeanOfChannel(scene.bands, spectrum.reflectance, c, 0) +
                                  spectrum.reradiation.WithinChannel(scene.bands, c);
      }
      if (!spectrum.exitance.empty()) {
        material.exitance[c] = SumOfChannel(scene.bands, spectrum.exitance, c);
      }
    }
    material.reradiation = spectrum.reradiation.BetweenChannels(scene.bands);
  }
}

SolveOptions Short(double accuracy = 0.02) {
  SolveOptions options;
  options.accuracy = accuracy;
  options.max_rounds = 2;
  return options;
}

// All faces alike, and of each band some of what arrives comes out in every longer one. Band 0
// alone is lit by lamps: all others have what fluorescence gives them.
TEST(BandFluorescence, AFurnaceGivesOutWhatItTakesIn) {
  for (const size_t n : {2, 4, 5, 7}) {
    BandReradiation matrix{n, std::vector<double>(n * n, 0.0)};
    std::vector<double> reflectance, exitance(n, 0.0), h(n, 0.0);
    exitance[0] = 1;
    for (size_t from = 0; from < n; ++from) {
      reflectance.push_back(0.1 + 0.05 * static_cast<double>(from));
      for (size_t to = from + 1; to < n; ++to) {
        matrix.shares[n * from + to] = 0.5 / static_cast<double>(n - 1 + to - from);
      }
    }
    for (size_t to = 0; to < n; ++to) {
      double given_out = exitance[to];
      for (size_t from = 0; from < to; ++from) given_out += matrix.Share(from, to) * h[from];
      h[to] = given_out / (1 - reflectance[to]);
    }
    Scene scene = FurnaceCube(0.5, 1);
    scene.bands = EvenBands(n);
    for (Material& material : scene.materials) {
      material.spectrum = {reflectance, {}, exitance, matrix};
    }
    SetChannels(scene);
    const SolveResult result = SolveScene(scene, Short(0.005));
    ASSERT_EQ(result.patch.bands.size(), n);
    const auto check = [&](const BandValues& values, size_t items) {
      for (size_t i = 0; i < items; ++i) {
        for (size_t b = 0; b < n; ++b) {
          EXPECT_NEAR(values.Irradiance(i, n)[b] / h[b], 1, 5e-3) << n << " " << b;
          EXPECT_NEAR(values.Radiosity(i, n)[b] / h[b], 1, 5e-3) << n << " " << b;
        }
      }
    };
    check(result.patch.vertex_bands, result.patch.vertices.size());
    check(result.patch.face_bands, result.patch.faces.size());
    // What is given out counts as emitted in its band, what is taken for it as absorbed in its own.
    size_t b = 0;
    for (const BandGroupSummary& group : result.summary.band_groups) {
      EXPECT_LT(group.energy_imbalance, 5e-3);
      for (const BandSummary& band : group.bands) {
        EXPECT_NEAR(band.emitted_w / (6 * (1 - reflectance[b]) * h[b]), 1, 5e-3) << n << " " << b;
        EXPECT_NEAR(band.absorbed_w / (6 * (1 - reflectance[b]) * h[b]), 1, 5e-3) << n << " " << b;
        ++b;
      }
      EXPECT_EQ(group.error_handed_on > 0, b > 3);
    }
    EXPECT_EQ(b, n);
    EXPECT_EQ(result.summary.band_groups.back().channels, 3U);
  }
}

// A box whose ceiling is lit in the shortest of five bands and whose other faces reflect, and
// reradiate, unlike each other, by full matrices of exact couplings, band by band.
struct FluorescentBox {
  static constexpr size_t kBands = 5;
  BoxFaces faces;
  std::array<BandReradiation, 6> matrix;

  FluorescentBox() {
    faces.reflectance = {Rgb(.6), Rgb(.3), Rgb(.5), Rgb(.2), Rgb(.4), Rgb(.3)};
    faces.exitance[5] = Rgb(1);
    matrix[0] = Matrix(kBands, {{0, 1, .1}, {0, 4, .2}});  // within the group, and to the next
    matrix[4] = Matrix(kBands, {{0, 3, .4}, {1, 2, .3}});
    matrix[3] = Matrix(kBands, {{3, 4, .5}});
  }

  Scene ToScene() const {
    Scene scene = BoxRoom(Vec3(1), faces);
    scene.bands = EvenBands(kBands);
    for (size_t f = 0; f < 6; ++f) {
      const bool lamp = f == 5;
      scene.materials[f].spectrum = {std::vector<double>(kBands, faces.reflectance[f].x),
                                     {},
                                     std::vector<double>(kBands, 0.0),
                                     matrix[f]};
      if (lamp) scene.materials[f].spectrum.exitance[0] = 1;
    }
    SetChannels(scene);
    return scene;
  }

  // Mean irradiance by band and face.
  std::array<std::array<double, 6>, kBands> Truth() const {
    GridBox box = MakeGridBox({1, 1, 1}, {8, 8, 8});
    const size_t n = box.leaves.size();
    for (size_t i = 0; i < n; ++i) {
      const double rho = faces.reflectance[box.face[i]].x;
      box.leaves.reflectance[i] = Lanes{rho, rho, rho, 0};
    }
    DenseTransport transport(box.coupling_m2, box.leaves);
    NullExchange exchange;
    std::array<std::array<double, 6>, kBands> means{};
    std::vector<std::vector<double>> h;
    for (size_t band = 0; band < kBands; ++band) {
      for (size_t i = 0; i < n; ++i) {
        double e = band == 0 ? faces.exitance[box.face[i]].x : 0.0;
        for (size_t from = 0; from < band; ++from) {
          e += matrix[box.face[i]].Share(from, band) * h[from][i];
        }
        box.leaves.exitance[i] = Lanes{e, e, e, 0};
      }
      const auto solved =
          Solve(SolverMethod::kConjugateGradients, transport, box.leaves,
                std::vector<Lanes>(n, Lanes{}), SolverOptions{.accuracy = 1e-8}, exchange);
      EXPECT_TRUE(solved.has_value());
      h.emplace_back();
      for (size_t i = 0; i < n; ++i) {
        h.back().push_back(solved->irradiance[i][0]);
        means[band][box.face[i]] += box.leaves.area_m2[i] * h.back().back();
      }
    }
    return means;
  }
};

TEST(BandFluorescence, AgreesWithFullMatrices) {
  const FluorescentBox box;
  constexpr size_t kBands = FluorescentBox::kBands;
  const SolveResult result = SolveScene(box.ToScene(), 0.02);
  const auto truth = box.Truth();
  std::array<std::array<double, 6>, kBands> found{};
  for (size_t f = 0; f < result.patch.faces.size(); ++f) {
    const PatchFace& face = result.patch.faces[f];
    const double part = std::ldexp(1.0, -NodeId{face.surface, face.path}.level());
    const auto h = result.patch.face_bands.Irradiance(f, kBands);
    const auto b = result.patch.face_bands.Radiosity(f, kBands);
    for (size_t band = 0; band < kBands; ++band) {
      found[band][face.polygon] += part * h[band];
      double radiosity = box.faces.reflectance[face.polygon].x * h[band] +
                         (band == 0 && face.polygon == 5 ? 1.0 : 0.0);
      for (size_t from = 0; from < band; ++from) {
        radiosity += box.matrix[face.polygon].Share(from, band) * h[from];
      }
      EXPECT_NEAR(b[band], radiosity, 1e-5 * radiosity + 1e-9);
    }
  }
  double off = 0, all = 0;
  for (size_t band = 0; band < kBands; ++band) {
    double off_band = 0, sum = 0;
    for (size_t f = 0; f < 6; ++f) {
      off_band += std::abs(found[band][f] - truth[band][f]);
      sum += truth[band][f];
    }
    EXPECT_LT(off_band / sum, 0.02) << band;
    off += off_band;
    all += sum;
  }
  EXPECT_LT(off / all, 0.02);
  EXPECT_GT(result.summary.rounds.back().error_estimate, off / all);
}

// A room with all that light can meet, a nearly blue lamp, a fluorescent wall and sheet.
Scene Room() {
  BoxFaces faces;
  faces.reflectance = {Rgb(.5, .4, .3), Rgb(.3), Rgb(.5), Rgb(.2, .4, .6), Rgb(.6), Rgb(.4)};
  faces.exitance[5] = Rgb(0.2, 0.1, 2);
  Scene scene = BoxRoom({2, 1, 1.5}, faces);
  AddSheet(scene, {{1, .2, .2}, {1.3, .2, 1}, {1.3, .8, 1}, {1, .8, .2}}, Rgb(.2), Rgb(.3));
  scene.materials[2].specular = 0.3;
  scene.bands = {{400, 430}, {430, 490}, {490, 530}, {530, 580}, {600, 700}};
  scene.materials[0].spectrum.reflectance = {.1, .2, .4, .4, .5};
  scene.materials[0].spectrum.reradiation = Matrix(5, {{0, 1, .1}, {0, 4, .6}, {1, 3, .3}});
  scene.materials.back().spectrum.reradiation = Matrix(5, {{1, 2, .2}, {1, 4, .1}});
  scene.materials.back().spectrum.reflectance = std::vector<double>(5, .2);
  SetChannels(scene);
  return scene;
}

TEST(BandFluorescence, TheSameOnOneAndThreeWorkers) {
  SolveToSameBits(Room(), Rotating(0.2, {1, 0.4}));
}

TEST(BandFluorescence, EnergyIsKept) {
  const SolveResult result = SolveScene(Room(), 0.05);
  ASSERT_EQ(result.summary.band_groups.size(), 2U);
  for (const BandGroupSummary& group : result.summary.band_groups) {
    EXPECT_LT(group.energy_imbalance, 5e-3);
  }
}

TEST(BandFluorescence, SwitchedOffItLeavesNoTrace) {
  Scene scene = Room();
  // Red, green and blue of before it.
  for (Material& material : scene.materials) {
    material.reradiation = {};
    for (int c = 0; c < 3; ++c) {
      material.reflectance[c] -= material.spectrum.reradiation.WithinChannel(scene.bands, c);
    }
  }
  Scene plain = scene;
  for (Material& material : plain.materials) material.spectrum.reradiation = {};
  const std::string off = BytesWithoutComments(SolveScene(scene, 0.3, "-fluorescence").patch);
  EXPECT_EQ(BytesWithoutComments(SolveScene(plain, 0.3, "+colour").patch) == off, true);
  EXPECT_EQ(BytesWithoutComments(SolveScene(scene, 0.3).patch) == off, false);
}

TEST(BandFluorescence, NeglectCostsNoMoreThanItsBound) {
  for (const double share : {0.001, 0.1, 0.4}) {
    Scene scene = FurnaceCube(0.5, 1);
    scene.bands = EvenBands(4);
    for (Material& material : scene.materials) {
      material.spectrum = {
          {.5, .4, .4, .4}, {}, {1, 1, 1, 1}, Matrix(4, {{0, 1, .5 * share}, {0, 3, .5 * share}})};
    }
    SetChannels(scene);
    const EffectsTable table = PlanEffects(Hierarchy(scene), 0.02, {});
    const auto row = std::ranges::find(table.effects, "fluorescence", &Effect::name);
    ASSERT_TRUE(row->present && row->bound.has_value());
    EXPECT_NEAR(*row->bound, share / .5, 1e-12);  // over 1 less the largest reflectance
    EXPECT_EQ(row->on, share > 0.01);
    EXPECT_EQ(std::ranges::count(table.to_measure, "fluorescence"), 0);
    const auto arriving = [&](const std::string& effects) {
      double sum_w = 0;
      for (const auto& group : SolveScene(scene, 0.05, effects).summary.band_groups) {
        sum_w += group.irradiance_w;
      }
      return sum_w;
    };
    const double all = arriving("+fluorescence"), cost = (all - arriving("-fluorescence")) / all;
    EXPECT_GT(cost, 0.2 * share);
    EXPECT_LT(cost, *row->bound);
  }
}

}  // namespace
}  // namespace isolux::testing
