// Spectral bands through whole solves: against the channels they repeat, closed forms of furnaces,
// and full matrices with exact couplings; energy band by band, and the same bits on any number of
// workers, whatever happens to them.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
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

// Two a channel, of one width; the blue ones first.
const std::vector<Band> kSix = {{430, 460}, {460, 490}, {490, 520},
                                {520, 550}, {600, 630}, {630, 660}};

// This many, from blue to red.
std::vector<Band> EvenBands(size_t count) {
  std::vector<Band> bands;
  const double width_nm = 300.0 / static_cast<double>(count);
  for (size_t b = 0; b < count; ++b) {
    const double low_nm = 400 + width_nm * static_cast<double>(b);
    bands.push_back({low_nm, low_nm + width_nm});
  }
  return bands;
}

// A coloured room with all that light can meet: a lamp, a dim point light, a sheet, a mirror, fog.
Scene Room() {
  BoxFaces faces;
  faces.reflectance = {Rgb(.6, .5, .4), Rgb(.3), Rgb(.5), Rgb(.2, .4, .6), Rgb(.6), Rgb(.4)};
  faces.exitance[5] = Rgb(1, 2, .5);
  Scene scene = BoxRoom({2, 1, 1.5}, faces);
  AddSheet(scene, {{1, .2, .2}, {1.3, .2, 1}, {1.3, .8, 1}, {1, .8, .2}}, Rgb(.2, .1, .3),
           Rgb(.4, .3, .2));
  scene.materials[2].specular = 0.3;
  scene.lights.push_back(
      {.name = "bulb", .position_m = {.4, .5, .6}, .intensity = {.01, .005, .02}});
  scene.medium.extinction_per_m = {.02, .05, .1};
  return scene;
}

SolveOptions Short(double accuracy = 0.2) {
  SolveOptions options;
  options.accuracy = accuracy;
  options.max_rounds = 2;
  return options;
}

double ErrorOf(const SolveResult& result) { return ErrorOfAll(result.summary.band_groups); }

// A furnace: all faces alike.
Scene Furnace(const std::vector<Band>& bands, const std::vector<double>& reflectance,
              const std::vector<double>& exitance) {
  Scene scene = FurnaceCube(0.5, 1);
  scene.bands = bands;
  for (Material& material : scene.materials) {
    material.spectrum = {reflectance, {}, exitance};
    for (int c = 0; c < 3; ++c) {
      material.reflectance[c] = MeanOfChannel(bands, reflectance, c, 0.5);
      material.exitance[c] = SumOfChannel(bands, exitance, c);
    }
  }
  return scene;
}

TEST(Bands, OfAFurnaceEachIsOnItsOwn) {
  for (const size_t count : {1, 2, 4, 5}) {
    std::vector<double> reflectance, exitance;
    for (size_t b = 0; b < count; ++b) {
      reflectance.push_back(0.1 + 0.15 * static_cast<double>(b));
      exitance.push_back(1 / (1 + static_cast<double>(b)));
    }
    const SolveResult result =
        SolveScene(Furnace(EvenBands(count), reflectance, exitance), Short(0.02));
    ASSERT_EQ(result.patch.bands.size(), count);
    const auto check = [&](const BandValues& values, size_t items) {
      ASSERT_EQ(values.values.size(), 2 * count * items);
      for (size_t i = 0; i < items; ++i) {
        for (size_t b = 0; b < count; ++b) {
          const double h = exitance[b] / (1 - reflectance[b]);
          EXPECT_NEAR(values.Irradiance(i, count)[b] / h, 1, 2e-3) << count << " " << b;
          EXPECT_NEAR(values.Radiosity(i, count)[b] / h, 1, 2e-3) << count << " " << b;
        }
      }
    };
    check(result.patch.vertex_bands, result.patch.vertices.size());
    check(result.patch.face_bands, result.patch.faces.size());
    ASSERT_EQ(result.summary.band_groups.size(), (count + 2) / 3);
    // A group of one band, or of bands that differ in nothing, takes one channel.
    const BandGroupSummary& last = result.summary.band_groups.back();
    EXPECT_EQ(last.channels, count % 3 == 1 ? 1U : 3U);
    size_t b = 0;
    for (const BandGroupSummary& group : result.summary.band_groups) {
      for (const BandSummary& band : group.bands) {
        EXPECT_NEAR(band.emitted_w, 6 * exitance[b], 1e-6);
        EXPECT_NEAR(band.absorbed_w / band.emitted_w, 1, 2e-3);
        EXPECT_EQ(band.escaped_w, 0);
        ++b;
      }
    }
    EXPECT_EQ(b, count);
  }
}

double Power(const BandSummary& band) { return band.absorbed_w + band.medium_w; }

// Bands that repeat the channels at half the power: the same light, in two parts. No spectrum is
// given, so all of it follows from the widths.
TEST(Bands, ThatRepeatTheChannelsGiveTheirLight) {
  Scene scene = Room();
  SolveOptions options;
  options.accuracy = 0.2;
  options.epsilons = {1, 0.4};
  const SolveResult channels = SolveScene(scene, options);
  scene.bands = {{430, 490}, {490, 550}, {600, 660}};
  const SolveResult three = SolveScene(scene, options);
  scene.bands = kSix;
  const SolveResult six = SolveScene(scene, options);
  ASSERT_EQ(six.patch.faces.size(), channels.patch.faces.size());
  ASSERT_EQ(six.patch.vertices.size(), channels.patch.vertices.size());
  ASSERT_EQ(six.summary.band_groups.size(), 2U);
  const RoundSummary& whole = channels.summary.rounds.back();
  const double unfinished = 2e-4 * options.accuracy;  // each group is iterated for itself
  for (size_t b = 0; b < 6; ++b) {
    const auto c = static_cast<size_t>(kSix[b].channel());
    const BandSummary& of_three = three.summary.band_groups[0].bands[b / 2];
    const BandSummary& of_six = six.summary.band_groups[b / 3].bands[b % 3];
    EXPECT_NEAR(of_three.emitted_w / whole.emitted_w[c], 1, 1e-9);
    EXPECT_NEAR(Power(of_three) / (whole.absorbed_w[c] + whole.medium_w[c]), 1, 0.02);
    EXPECT_NEAR(of_six.emitted_w / of_three.emitted_w, 0.5, 1e-9);
    EXPECT_NEAR(of_six.absorbed_w / of_three.absorbed_w, 0.5, unfinished);
    EXPECT_NEAR(of_six.medium_w / of_three.medium_w, 0.5, unfinished);
    EXPECT_NEAR((Power(of_six) + of_six.escaped_w) / of_six.emitted_w, 1, 0.02);
    // Rays go, and sources are opened, where a group's own light is: points differ by less than
    // the error that is stated.
    double off = 0, sum = 0;
    for (size_t f = 0; f < six.patch.faces.size(); ++f) {
      const double h = 0.5 * three.patch.face_bands.Irradiance(f, 3)[b / 2];
      off += std::abs(six.patch.face_bands.Irradiance(f, 6)[b] - h);
      sum += h;
    }
    EXPECT_LT(off / sum, six.summary.rounds.back().error_estimate) << b;
  }
  // The channels are the sums of the bands.
  for (size_t v = 0; v < six.patch.vertices.size(); ++v) {
    const auto h = six.patch.vertex_bands.Irradiance(v, 6);
    EXPECT_NEAR(six.patch.vertices[v].irradiance[2], h[0] + h[1], 1e-5 * (h[0] + h[1]));
    EXPECT_NEAR(six.patch.vertices[v].irradiance[0], h[4] + h[5], 1e-5 * (h[4] + h[5]));
  }
  EXPECT_GE(six.summary.rounds.back().error_estimate, ErrorOf(six));
}

// Where nothing differs between bands all of them are alike.
TEST(Bands, OfGreyLightAreTheirShareOfIt) {
  BoxFaces faces;
  faces.reflectance = {Rgb(.6), Rgb(.3), Rgb(.5), Rgb(.2), Rgb(.6), Rgb(.4)};
  faces.exitance[5] = Rgb(1);
  Scene scene = BoxRoom({2, 1, 1.5}, faces);
  SolveOptions options;
  options.accuracy = 1e-5;
  options.epsilons = {0.1, 0.02};
  options.effects = "+colour";  // three channels for grey light, too
  const SolveResult channels = SolveScene(scene, options);
  scene.bands = kSix;
  const SolveResult bands = SolveScene(scene, options);
  ASSERT_EQ(bands.patch.faces.size(), channels.patch.faces.size());
  for (const BandGroupSummary& group : bands.summary.band_groups) EXPECT_EQ(group.channels, 1U);
  for (size_t f = 0; f < bands.patch.faces.size(); ++f) {
    const auto h = bands.patch.face_bands.Irradiance(f, 6);
    for (size_t b = 0; b < 6; ++b) EXPECT_NEAR(h[b] / h[0], 1, 1e-6);
    // These are solved as far as the rounds reach.
    EXPECT_NEAR(channels.patch.faces[f].irradiance[1] / (2 * h[0]), 1, 5e-3);
  }
}

// Mean irradiance of the faces of a box in one band, by a full matrix of exact couplings.
std::array<double, 6> DenseMeans(const BoxFaces& faces, int channel) {
  GridBox box = MakeGridBox({1, 1, 1}, {6, 6, 6});
  for (size_t i = 0; i < box.leaves.size(); ++i) {
    const double rho = faces.reflectance[box.face[i]][channel];
    const double e = faces.exitance[box.face[i]][channel];
    box.leaves.reflectance[i] = Lanes{rho, rho, rho, 0};
    box.leaves.exitance[i] = Lanes{e, e, e, 0};
  }
  DenseTransport transport(box.coupling_m2, box.leaves);
  NullExchange exchange;
  const auto solved = Solve(SolverMethod::kConjugateGradients, transport, box.leaves,
                            std::vector<Lanes>(box.leaves.size(), Lanes{}),
                            SolverOptions{.accuracy = 1e-8}, exchange);
  EXPECT_TRUE(solved.has_value());
  std::array<double, 6> sum{};
  for (size_t i = 0; i < box.leaves.size(); ++i) {
    sum[box.face[i]] += box.leaves.area_m2[i] * solved->irradiance[i][0];  // of 1 m² each
  }
  return sum;
}

// Walls that are alike in green, but not in its two bands: what comes back from one onto the other
// tells them apart.
TEST(Bands, TellMetamersApart) {
  BoxFaces guide, first, second;
  guide.reflectance.fill(Rgb(0.5));
  guide.exitance[5] = Rgb(0, 2, 0);
  first = second = guide;
  for (const int f : {0, 1, 2, 3, 4}) {
    first.reflectance[f] = Rgb(0.95);
    second.reflectance[f] = Rgb(0.05);
  }
  first.exitance[5] = second.exitance[5] = Rgb(0, 1, 0);
  Scene scene = BoxRoom(Vec3(1), guide);
  scene.bands = {{490, 520}, {520, 550}};
  for (size_t f = 0; f < 6; ++f) {
    scene.materials[f].spectrum.reflectance = {first.reflectance[f].y, second.reflectance[f].y};
  }
  const SolveResult result = SolveScene(scene, 0.01);
  const auto of_guide = DenseMeans(guide, 1);
  const std::array<std::array<double, 6>, 2> truth{DenseMeans(first, 1), DenseMeans(second, 1)};
  std::array<std::array<double, 6>, 2> found{};
  std::array<double, 6> area{};
  for (size_t f = 0; f < result.patch.faces.size(); ++f) {
    const PatchFace& face = result.patch.faces[f];
    const double part = std::ldexp(1.0, -NodeId{face.surface, face.path}.level());
    area[face.polygon] += part;
    for (size_t b = 0; b < 2; ++b) {
      found[b][face.polygon] += part * result.patch.face_bands.Irradiance(f, 2)[b];
    }
  }
  for (size_t b = 0; b < 2; ++b) {
    double off = 0, sum = 0, off_guide = 0;
    for (size_t f = 0; f < 6; ++f) {
      EXPECT_NEAR(area[f], 1, 1e-9);
      off += std::abs(found[b][f] - truth[b][f]);
      off_guide += std::abs(0.5 * of_guide[f] - truth[b][f]);
      sum += truth[b][f];
    }
    EXPECT_LT(off / sum, 0.01) << b;       // as asked for
    EXPECT_GT(off_guide / sum, 0.2) << b;  // half of green is far from either
  }
}

TEST(Bands, WithoutLightAreDark) {
  const std::vector<Band> bands = {{320, 350}, {350, 380}, {380, 400}, {490, 520}};
  const SolveResult result =
      SolveScene(Furnace(bands, {.5, .6, .7, .8}, {0, 0, 0, 1}), Short(0.05));
  ASSERT_EQ(result.summary.band_groups.size(), 2U);
  EXPECT_EQ(result.summary.band_groups[0].iterations, 0U);
  for (size_t f = 0; f < result.patch.faces.size(); ++f) {
    const auto h = result.patch.face_bands.Irradiance(f, 4);
    EXPECT_EQ(h[0] + h[1] + h[2], 0);
    EXPECT_NEAR(h[3], 5, 0.02);
  }
}

Scene SixBandRoom() {
  Scene scene = Room();
  scene.bands = kSix;
  scene.materials[0].spectrum.reflectance = {.1, .7, .4, .6, .8, .4};
  scene.materials[5].spectrum.exitance = {.1, .4, 1.5, .5, .3, .7};
  // Opaque in all of the second group.
  scene.materials.back().spectrum.transmittance = {.1, .3, .6, 0, 0, 0};
  return scene;
}

TEST(Bands, TheSameOnAnyNumberOfWorkersWhateverBecomesOfThem) {
  const SolveOptions options = Rotating(0.2, {1, 0.4});
  const std::string reference = BytesWithoutComments(SolveToSameBits(SixBandRoom(), options).patch);
  for (const uint32_t group : {1U, 2U}) {
    LocalCluster cluster(3, 1);
    JobCallbacks callbacks;
    std::atomic<int> lost{0};
    bool done = false;
    callbacks.on_progress = [&](const JobProgress& progress) {
      if (done || progress.group != group) return;
      EXPECT_EQ(ToText(progress), fmt::format("bands, group {} of 2", group));
      done = true;
      cluster.Kill(1);
    };
    callbacks.on_lost = [&](const WorkerSlot&, const Status&) { ++lost; };
    auto result = RunJob(cluster, MakeJobInput(SixBandRoom(), options), callbacks);
    ASSERT_TRUE(result.has_value()) << result.error().message();
    EXPECT_EQ(lost, 1);
    EXPECT_EQ(result->summary.rounds.size(), 2U);
    EXPECT_EQ(BytesWithoutComments(std::move(result->patch)) == reference, true) << group;
  }
}

TEST(Bands, AreARowOfTheEffectsAndCanBeSwitchedOff) {
  const Scene scene = SixBandRoom();
  const EffectsTable table = PlanEffects(Hierarchy(scene), 0.02, {});
  const auto row = std::ranges::find(table.effects, "colour", &Effect::name);
  EXPECT_NE(row->evidence.find("6 spectral bands in 2 groups"), std::string::npos) << row->evidence;
  EXPECT_TRUE(row->on && table.plan.bands);
  EXPECT_FALSE(row->bound.has_value());
  Scene plain = scene;
  plain.bands.clear();
  for (Material& material : plain.materials) material.spectrum = {};
  const std::string off = BytesWithoutComments(SolveScene(scene, 0.3, "-colour").patch);
  EXPECT_EQ(BytesWithoutComments(SolveScene(plain, 0.3, "-colour").patch) == off, true);
}

}  // namespace
}  // namespace isolux::testing
