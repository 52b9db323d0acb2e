#include "tests/support/dense_transport.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isolux::testing {
namespace {

// A cell of a wall: its extent in each direction, one of them nothing.
struct Cell {
  int axis = 0;  // the one that it is perpendicular to
  std::array<double, 3> low{}, high{};
};

// Second antiderivative of the coupling of strips that face each other at distance z.
double Parallel(double u, double v, double z) {
  const double a = std::sqrt(u * u + z * z), b = std::sqrt(v * v + z * z);
  return (v * a * std::atan(v / a) + u * b * std::atan(u / b) -
          0.5 * z * z * std::log(u * u + v * v + z * z)) /
         (2 * std::numbers::pi);
}

// The same of perpendicular ones: x and y from the common line, v along it.
double Perpendicular(double x, double y, double v) {
  const double d2 = x * x + y * y, d = std::sqrt(d2);
  if (d2 + v * v == 0) return 0;
  return (v * d * std::atan2(v, d) - 0.25 * (d2 - v * v) * std::log(d2 + v * v)) /
         (2 * std::numbers::pi);
}

// Fourth difference over the corners of two intervals a and b in one direction and of two in
// another: f of the differences of coordinates.
template <typename Function>
double OverDifferences(const std::array<double, 2>& a, const std::array<double, 2>& b,
                       const Function& f) {
  double sum = 0;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) sum += (i == k ? 1 : -1) * f(a[i] - b[k]);
  }
  return sum;
}

double CouplingOf(const Cell& p, const Cell& q) {
  const auto range = [](const Cell& cell, int axis) {
    return std::array<double, 2>{cell.low[axis], cell.high[axis]};
  };
  if (p.axis == q.axis) {
    const double z = std::abs(p.low[p.axis] - q.low[q.axis]);
    if (z == 0) return 0;
    const int s = (p.axis + 1) % 3, t = (p.axis + 2) % 3;
    return std::abs(OverDifferences(range(p, s), range(q, s), [&](double u) {
      return OverDifferences(range(p, t), range(q, t), [&](double v) { return Parallel(u, v, z); });
    }));
  }
  // Distances from the line in which the two planes meet.
  const int along = 3 - p.axis - q.axis;
  const auto distance = [](const Cell& cell, const Cell& other) {
    const double line = other.low[other.axis];
    return std::array<double, 2>{std::abs(cell.low[other.axis] - line),
                                 std::abs(cell.high[other.axis] - line)};
  };
  const auto x = distance(p, q), y = distance(q, p);
  double sum = 0;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) {
      sum += (i == k ? 1 : -1) * OverDifferences(range(p, along), range(q, along), [&](double v) {
               return Perpendicular(x[i], y[k], v);
             });
    }
  }
  return std::abs(sum);
}

}  // namespace

DenseTransport::DenseTransport(std::vector<double> coupling_m2, const LeafSystem& leaves)
    : coupling_m2_(std::move(coupling_m2)), leaves_(leaves) {}

Lanes DenseTransport::Row(size_t leaf, std::span<const Lanes> radiosity) {
  const size_t n = radiosity.size();
  const double* row = coupling_m2_.data() + leaf * n;
  Lanes sum{};
  for (size_t k = 0; k < n; ++k) sum += radiosity[k] * (row[k] * leaves_.closure[k]);
  multiply_adds_ += n;
  return sum * (leaves_.closure[leaf] / leaves_.area_m2[leaf]);
}

Status DenseTransport::Irradiance(std::span<const Lanes> radiosity, const Lanes&,
                                  std::span<Lanes> irradiance) {
  for (size_t i = 0; i < radiosity.size(); ++i) irradiance[i] = Row(i, radiosity);
  return {};
}

Status DenseTransport::IrradianceFromOthers(std::span<const Lanes>, const Lanes&,
                                            std::span<Lanes> irradiance) {
  std::fill(irradiance.begin(), irradiance.end(), Lanes{});
  return {};
}

void DenseTransport::Sweep(std::span<Lanes> radiosity, std::span<const Lanes> from_others,
                           const Update& update) {
  for (size_t i = 0; i < radiosity.size(); ++i)
    radiosity[i] = update(i, from_others[i] + Row(i, radiosity));
}

void DenseTransport::Shoot(size_t leaf, const Lanes& radiosity, std::span<Lanes> irradiance) {
  const size_t n = irradiance.size();
  const double* row = coupling_m2_.data() + leaf * n;
  const Lanes sent = radiosity * leaves_.closure[leaf];
  for (size_t k = 0; k < n; ++k) {
    irradiance[k] += sent * (row[k] * leaves_.closure[k] / leaves_.area_m2[k]);
  }
  multiply_adds_ += 2 * n;  // what arrives, and the power that the next choice compares
}

GridBox MakeGridBox(const std::array<double, 3>& size_m, const std::array<int, 3>& cells) {
  std::vector<Cell> all;
  GridBox box;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, s = (axis + 1) % 3, t = (axis + 2) % 3;
    for (int i = 0; i < cells[s]; ++i) {
      for (int k = 0; k < cells[t]; ++k) {
        Cell cell;
        cell.axis = axis;
        cell.low[axis] = cell.high[axis] = face % 2 == 0 ? 0 : size_m[axis];
        cell.low[s] = size_m[s] * i / cells[s];
        cell.high[s] = size_m[s] * (i + 1) / cells[s];
        cell.low[t] = size_m[t] * k / cells[t];
        cell.high[t] = size_m[t] * (k + 1) / cells[t];
        all.push_back(cell);
        box.face.push_back(static_cast<uint8_t>(face));
        box.leaves.area_m2.push_back((cell.high[s] - cell.low[s]) * (cell.high[t] - cell.low[t]));
      }
    }
  }
  const size_t n = all.size();
  box.leaves.reflectance.assign(n, Lanes{});
  box.leaves.exitance.assign(n, Lanes{});
  box.leaves.closure.assign(n, 1.0);
  box.coupling_m2.assign(n * n, 0);
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < i; ++k) {
      box.coupling_m2[i * n + k] = box.coupling_m2[k * n + i] = CouplingOf(all[i], all[k]);
    }
  }
  return box;
}

double CloseDense(const std::vector<double>& coupling_m2, double tolerance, LeafSystem* leaves) {
  const size_t n = leaves->size();
  std::vector<double> row(n);
  for (int step = 0;; ++step) {
    double worst = 0;
    for (size_t i = 0; i < n; ++i) {
      row[i] = 0;
      for (size_t k = 0; k < n; ++k) row[i] += coupling_m2[i * n + k] * leaves->closure[k];
      row[i] *= leaves->closure[i] / leaves->area_m2[i];
      worst = std::max(worst, std::abs(row[i] - 1));
    }
    if (worst <= tolerance || step == 1000) return worst;
    for (size_t i = 0; i < n; ++i) leaves->closure[i] /= std::sqrt(row[i]);
  }
}

}  // namespace isolux::testing
