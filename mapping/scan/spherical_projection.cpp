#include "mapping/scan/spherical_projection.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace cloister {
namespace {

constexpr double kAngleTolerance = 1e-4;   // rad
constexpr double kLengthTolerance = 1e-3;  // m
constexpr int kMinColumns = 64;
constexpr double kTurn = 2 * std::numbers::pi;

double azimuth_of(const Eigen::Vector3f& v) { return std::atan2(double{v.y()}, double{v.x()}); }
/// The same angle within half a turn of zero.
double wrapped(double angle_rad) { return std::remainder(angle_rad, kTurn); }

/// A beam as a line in the half-plane (rho, z) that it lies in, up to its small distance from the axis.
struct Line {
  double azimuth_rad, rho_m, z_m, tangential_m, cos_up, sin_up;
};

Line line_of(const Eigen::Vector3f& direction_L, const Eigen::Vector3f& origin_L) {
  const double azimuth = azimuth_of(direction_L);
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  return {azimuth,
          origin_L.x() * c + origin_L.y() * s,
          origin_L.z(),
          origin_L.y() * c - origin_L.x() * s,
          std::hypot(double{direction_L.x()}, double{direction_L.y()}),
          direction_L.z()};
}

/// Point (rho, z) nearest to all lines, least squares.
Eigen::Vector2d meeting_point(const std::vector<Line>& lines) {
  Eigen::Matrix2d normal = 1e-12 * Eigen::Matrix2d::Identity();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Line& line : lines) {
    const Eigen::Vector2d across(line.sin_up, -line.cos_up);
    normal += across * across.transpose();
    right += across * across.dot(Eigen::Vector2d(line.rho_m, line.z_m));
  }
  // A sensor of one row, or of parallel ones, leaves the distance along them open: nearest to the axis, then.
  if (normal.determinant() < 1e-9) return {lines.front().rho_m, lines.front().z_m};
  return normal.inverse() * right;
}

std::vector<float> make_row_table(const std::vector<SphericalProjection::Row>& rows) {
  constexpr int kSteps = SphericalProjection::kSineSteps;
  const int last = static_cast<int>(rows.size()) - 1;
  std::vector<float> table(kSteps + 2);
  int above = 0;
  for (int i = kSteps + 1; i >= 0; --i) {  // from the zenith down
    const double elevation = std::asin(std::clamp(2.0 * i / kSteps - 1, -1.0, 1.0));
    while (above + 2 <= last && rows[above + 1].elevation_rad >= elevation) ++above;
    // Beyond the outermost rows the spacing of the two nearest goes on.
    const double pitch =
        last > 0 ? rows[above].elevation_rad - rows[above + 1].elevation_rad : kTurn / 1024;
    table[i] = static_cast<float>(above + (rows[above].elevation_rad - elevation) / pitch);
  }
  return table;
}

}  // namespace

std::optional<SphericalProjection> fit_projection(int num_beams, int num_columns,
                                                  const std::vector<Eigen::Vector3f>& direction_L,
                                                  const std::vector<Eigen::Vector3f>& origin_L) {
  const std::size_t num_pixels =
      static_cast<std::size_t>(num_beams) * static_cast<std::size_t>(num_columns);
  if (num_beams < 1 || num_columns < kMinColumns ||
      !std::has_single_bit(static_cast<unsigned>(num_columns)) ||
      direction_L.size() != num_pixels || origin_L.size() != num_pixels) {
    return std::nullopt;
  }
  SphericalProjection projection;
  projection.num_columns = num_columns;
  const double turn = wrapped(azimuth_of(direction_L[1]) - azimuth_of(direction_L[0]));
  const double step = std::copysign(kTurn / num_columns, turn);
  projection.columns_per_rad = static_cast<float>(1 / step);

  std::vector<Line> lines;
  std::vector<double> azimuth0;  // of each row's column 0
  for (int row = 0; row < num_beams; ++row) {
    const std::size_t first = static_cast<std::size_t>(row) * num_columns;
    const Line line = line_of(direction_L[first], origin_L[first]);
    for (int column = 0; column < num_columns; ++column) {
      const Line other = line_of(direction_L[first + column], origin_L[first + column]);
      if (std::abs(wrapped(other.azimuth_rad - line.azimuth_rad - step * column)) >
              kAngleTolerance ||
          std::abs(other.sin_up - line.sin_up) > kAngleTolerance ||
          std::hypot(other.rho_m - line.rho_m, other.z_m - line.z_m,
                     other.tangential_m - line.tangential_m) > kLengthTolerance) {
        return std::nullopt;
      }
    }
    lines.push_back(line);
    azimuth0.push_back(line.azimuth_rad);
  }

  // Column 0 of the image: in the middle of the rows' columns 0, where the rows' columns agree best.
  double fraction = 0, least = 0, most = 0;
  for (const double azimuth : azimuth0) {
    const double columns = wrapped(azimuth - azimuth0[0]) / step;
    fraction += columns - std::round(columns);
    least = std::min(least, std::round(columns));
    most = std::max(most, std::round(columns));
  }
  const double middle = std::round(0.5 * (least + most));
  const double image_azimuth0 = wrapped(azimuth0[0] + (middle + fraction / num_beams) * step);
  projection.azimuth0_rad = static_cast<float>(image_azimuth0);

  const Eigen::Vector2d ring = meeting_point(lines);
  projection.ring_radius_m = static_cast<float>(ring.x());
  projection.ring_height_m = static_cast<float>(ring.y());
  for (int row = 0; row < num_beams; ++row) {
    const Line& line = lines[row];
    const Eigen::Vector2d to_ring = ring - Eigen::Vector2d(line.rho_m, line.z_m);
    if (std::abs(to_ring.x() * line.sin_up - to_ring.y() * line.cos_up) > kLengthTolerance)
      return std::nullopt;
    if (row > 0 && line.sin_up >= lines[row - 1].sin_up) return std::nullopt;
    // The scan's column c of this row stands at azimuth0[row] + step * c.
    const double offset_columns = wrapped(azimuth0[row] - image_azimuth0) / step;
    const double residual = (offset_columns - std::round(offset_columns)) * step;
    const int shift = -static_cast<int>(std::lround(offset_columns));
    projection.max_shift = std::max(projection.max_shift, std::abs(shift));
    projection.rows.push_back(
        {static_cast<float>(std::asin(std::clamp(line.sin_up, -1.0, 1.0))),
         static_cast<float>(line.sin_up), static_cast<float>(line.cos_up),
         static_cast<float>(std::sin(residual)), static_cast<float>(std::cos(residual)),
         static_cast<float>(to_ring.x() * line.cos_up + to_ring.y() * line.sin_up),
         static_cast<float>(line.tangential_m),
         ((shift % num_columns) + num_columns) % num_columns});
  }
  for (int column = 0; column < num_columns; ++column) {
    projection.cos_azimuth.push_back(static_cast<float>(std::cos(image_azimuth0 + step * column)));
    projection.sin_azimuth.push_back(static_cast<float>(std::sin(image_azimuth0 + step * column)));
  }
  projection.row_of_sine = make_row_table(projection.rows);
  for (int row = 1; row < num_beams; ++row) {
    const float pitch = projection.rows[row - 1].elevation_rad - projection.rows[row].elevation_rad;
    projection.max_rows_per_rad = std::max(projection.max_rows_per_rad, 1 / pitch);
  }
  if (num_beams > 1) {
    const double pitch =
        double{projection.rows.front().elevation_rad - projection.rows.back().elevation_rad} /
        (num_beams - 1);
    projection.squaring =
        std::clamp(static_cast<int>(std::lround(std::log2(pitch / std::abs(step)))), 0, 3);
  }
  return projection;
}

}  // namespace cloister
