#include "firmware_interface/ros2/beam_table_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cloister::ros2 {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kMaxRms_m = 0.002;
constexpr double kMaxRms_rad = 0.002;
constexpr double kAngleTolerance_rad = 5e-5;
constexpr double kLengthTolerance_m = 5e-4;
/// Points nearer than this say little about where a beam looks.
constexpr double kMinRho_m = 0.3;
/// What even perfect points are off: they come as floats.
constexpr double kLeastSigma = 1e-5;
constexpr double kMinPoints = 8;

double wrapped(double angle_rad) { return std::remainder(angle_rad, kTurn); }

}  // namespace

BeamTableFit::BeamTableFit(int num_rows, int num_columns)
    : num_rows_(num_rows), num_columns_(num_columns), rows_(static_cast<std::size_t>(num_rows)) {}

void BeamTableFit::Line::add(double px, double py) {
  n += 1;
  x += px;
  y += py;
  xx += px * px;
  xy += px * py;
  yy += py * py;
}

bool BeamTableFit::Line::solve(double max_rms, double offset_tolerance, double slope_tolerance) {
  if (n < kMinPoints) return false;
  const double sxx = xx - x * x / n;
  const double sxy = xy - x * y / n;
  const double syy = yy - y * y / n;
  if (!(sxx > 1e-12 * xx)) return false;
  slope = sxy / sxx;
  offset = (y - slope * x) / n;
  const double rms = std::sqrt(std::max(0.0, syy - slope * sxy) / n);
  const double sigma = std::max(rms, kLeastSigma);
  return rms <= max_rms && sigma / std::sqrt(sxx) <= slope_tolerance &&
         sigma * std::sqrt(xx / (n * sxx)) <= offset_tolerance;
}

void BeamTableFit::find_turn(std::span<const Eigen::Vector3f> points_L) {
  int balance = 0;
  for (std::size_t i = 1; i < points_L.size(); ++i) {
    const Eigen::Vector3f& a = points_L[i - 1];
    const Eigen::Vector3f& b = points_L[i];
    const float turn = a.x() * b.y() - a.y() * b.x();
    balance += (turn > 0) - (turn < 0);  // neither for a NaN
  }
  if (balance != 0) step_rad_ = std::copysign(kTurn / num_columns_, balance);
}

void BeamTableFit::add(std::span<const Eigen::Vector3f> points_L) {
  if (step_rad_ == 0) find_turn(points_L);
  if (step_rad_ == 0) return;
  for (int r = 0; r < num_rows_; ++r) {
    Row& row = rows_[static_cast<std::size_t>(r)];
    if (row.is_known) continue;
    for (int column = 0; column < num_columns_; ++column) {
      const Eigen::Vector3d p =
          points_L[static_cast<std::size_t>(r) * num_columns_ + column].cast<double>();
      const double rho = std::hypot(p.x(), p.y());
      if (!(rho >= kMinRho_m) || !std::isfinite(p.z())) continue;
      const double azimuth = std::atan2(p.y(), p.x()) - step_rad_ * column;
      if (!row.has_reference) {
        row.azimuth_reference_rad = azimuth;
        row.has_reference = true;
      }
      row.height_of_rho.add(rho, p.z());
      row.azimuth_of_inverse_rho.add(1 / rho, wrapped(azimuth - row.azimuth_reference_rad));
    }
    // A slope's tolerance is an angle here, and a length there.
    row.is_known =
        row.height_of_rho.solve(kMaxRms_m, kLengthTolerance_m, kAngleTolerance_rad) &&
        row.azimuth_of_inverse_rho.solve(kMaxRms_rad, kAngleTolerance_rad, kLengthTolerance_m);
    if (!row.is_known) continue;
    row.elevation_rad = std::atan(row.height_of_rho.slope);
    row.azimuth_rad = wrapped(row.azimuth_reference_rad + row.azimuth_of_inverse_rho.offset);
    row.tangential_m = row.azimuth_of_inverse_rho.slope;
  }
}

int BeamTableFit::num_known_rows() const {
  return static_cast<int>(std::ranges::count(rows_, true, &Row::is_known));
}

BeamTableFit::Ring BeamTableFit::find_ring() const {
  Line height_of_slope;
  for (const Row& row : rows_) {
    if (row.is_known) height_of_slope.add(row.height_of_rho.slope, row.height_of_rho.offset);
  }
  // Rows that are as good as parallel leave the radius open, and do not care.
  constexpr double kAny = 1e9;
  if (!height_of_slope.solve(kAny, kAny, 1.0)) return {0, height_of_slope.y / height_of_slope.n};
  return {-height_of_slope.slope, height_of_slope.offset};
}

std::vector<BeamTableFit::Row> BeamTableFit::completed_rows(const Ring& ring) const {
  std::vector<Row> rows = rows_;
  for (Row& row : rows) {
    if (!row.is_known) continue;
    const Line& line = row.height_of_rho;
    const double xx = line.xx - 2 * ring.radius_m * line.x + line.n * ring.radius_m * ring.radius_m;
    const double xy = line.xy - ring.height_m * line.x - ring.radius_m * line.y +
                      line.n * ring.radius_m * ring.height_m;
    row.elevation_rad = std::atan2(xy, xx);
  }
  for (int r = 0; r < num_rows_; ++r) {
    Row& row = rows[static_cast<std::size_t>(r)];
    if (row.is_known) continue;
    // The nearest two known rows, on both sides where there are.
    int above = r - 1, below = r + 1;
    while (above >= 0 && !is_known(above)) --above;
    while (below < num_rows_ && !is_known(below)) ++below;
    if (above < 0) {
      above = below++;
      while (below < num_rows_ && !is_known(below)) ++below;
    } else if (below >= num_rows_) {
      below = above--;
      while (above >= 0 && !is_known(above)) --above;
    }
    const Row& a = rows[static_cast<std::size_t>(above)];
    const Row& b = rows[static_cast<std::size_t>(below)];
    const double fraction = static_cast<double>(r - above) / (below - above);
    const auto between = [fraction](double at_a, double at_b) {
      return at_a + fraction * (at_b - at_a);
    };
    row.elevation_rad = between(a.elevation_rad, b.elevation_rad);
    const Row& nearest = std::abs(r - above) <= std::abs(r - below) ? a : b;
    row.azimuth_rad = nearest.azimuth_rad;
    row.tangential_m = nearest.tangential_m;
  }
  return rows;
}

std::unique_ptr<const ScanGeometry> BeamTableFit::geometry(
    std::span<const int> first_column) const {
  if (num_known_rows() < std::max(2, (num_rows_ + 1) / 2)) return nullptr;
  auto geometry = std::make_unique<ScanGeometry>();
  geometry->num_beams = num_rows_;
  geometry->num_columns = num_columns_;
  const std::size_t num_pixels = static_cast<std::size_t>(num_rows_) * num_columns_;
  geometry->direction_L.reserve(num_pixels);
  geometry->origin_L.reserve(num_pixels);
  const Ring ring = find_ring();
  const std::vector<Row> rows = completed_rows(ring);
  for (int r = 0; r < num_rows_; ++r) {
    const Row& row = rows[static_cast<std::size_t>(r)];
    const double missed_m =
        row.height_of_rho.offset + ring.radius_m * row.height_of_rho.slope - ring.height_m;
    if (row.is_known && !(std::abs(missed_m) <= kMaxRms_m)) return nullptr;
    const int first = first_column[static_cast<std::size_t>(r)];
    geometry->pixel_shift.push_back(first > num_columns_ / 2 ? first - num_columns_ : first);
    const double cos_up = std::cos(row.elevation_rad), sin_up = std::sin(row.elevation_rad);
    for (int fired = 0; fired < num_columns_; ++fired) {
      const int column = (fired + first) % num_columns_;
      const double azimuth = row.azimuth_rad + step_rad_ * column;
      const double c = std::cos(azimuth), s = std::sin(azimuth);
      geometry->direction_L.emplace_back(
          Eigen::Vector3d(c * cos_up, s * cos_up, sin_up).cast<float>());
      geometry->origin_L.emplace_back(Eigen::Vector3d(ring.radius_m * c - s * row.tangential_m,
                                                      ring.radius_m * s + c * row.tangential_m,
                                                      ring.height_m)
                                          .cast<float>());
    }
  }
  geometry->projection =
      fit_projection(num_rows_, num_columns_, geometry->direction_L, geometry->origin_L);
  if (!geometry->projection) return nullptr;
  return geometry;
}

}  // namespace cloister::ros2
