#include "firmware_interface/ros2/point_cloud_message.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "firmware_interface/ros2/cloud_layout.hpp"
#include "firmware_interface/ros2/message_parts.hpp"

namespace cloister::ros2 {
namespace {

/// Clouds that may go into one fit. What a sensor standing in a room has not shown by then, it will not show soon.
constexpr int kMaxCloudsInFit = 100;
constexpr int kMinColumns = 64;
/// A return this far off its beam, or this share of its range, is not of that beam.
constexpr float kMaxMiss_m = 0.005f;
constexpr float kMaxMissShare = 0.0005f;
constexpr float kMaxRange_m = 1e5f;
/// Clouds with more such returns are not as the table has it.
constexpr int kMaxMisfitShare = 50;

std::size_t size_of(std::uint8_t datatype) {
  switch (datatype) {
    case kUint8:
      return 1;
    case kUint16:
      return 2;
    case kFloat64:
      return 8;
    default:
      return 4;
  }
}

/// One field of every point.
class FieldReader {
 public:
  FieldReader() = default;
  /// The field of a name, if it has one of the types and lies within a point; else a reader that is false.
  FieldReader(const PointCloud2& message, std::string_view name,
              std::initializer_list<std::uint8_t> types)
      : is_swapped_(message.is_bigendian != (std::endian::native == std::endian::big)) {
    for (std::uint32_t i = 0; i < message.fields._length; ++i) {
      const PointField& field = message.fields._buffer[i];
      if (field.name == nullptr || field.name != name) continue;
      if (std::ranges::find(types, field.datatype) == types.end()) continue;
      if (field.offset + std::uint64_t{size_of(field.datatype)} > message.point_step) continue;
      offset_ = field.offset;
      datatype_ = field.datatype;
      return;
    }
  }

  explicit operator bool() const { return datatype_ != 0; }
  [[nodiscard]] float number(const std::uint8_t* point) const {
    if (datatype_ == kFloat32) return std::bit_cast<float>(bits<std::uint32_t>(point));
    return static_cast<float>(std::bit_cast<double>(bits<std::uint64_t>(point)));
  }
  [[nodiscard]] std::uint32_t count(const std::uint8_t* point) const {
    if (datatype_ == kUint8) return point[offset_];
    if (datatype_ == kUint16) return bits<std::uint16_t>(point);
    return bits<std::uint32_t>(point);
  }

 private:
  template <typename Unsigned>
  [[nodiscard]] Unsigned bits(const std::uint8_t* point) const {
    std::array<std::uint8_t, sizeof(Unsigned)> bytes;
    std::memcpy(bytes.data(), point + offset_, bytes.size());
    if (is_swapped_) std::ranges::reverse(bytes);
    return std::bit_cast<Unsigned>(bytes);
  }

  bool is_swapped_ = false;
  std::uint32_t offset_ = 0;
  std::uint8_t datatype_ = 0;
};

bool is_image_of_turn(int rows, int columns) {
  return rows > 1 && columns >= kMinColumns && columns <= PointCloudDecoder::kMaxColumns &&
         std::has_single_bit(static_cast<unsigned>(columns));
}

}  // namespace

std::optional<MessageCause> PointCloudDecoder::read(const PointCloud2& message) {
  const std::uint64_t num_points = std::uint64_t{message.height} * message.width;
  if (num_points == 0) return MessageCause::kEmptyCloud;
  if (num_points > max_points_) return MessageCause::kCloudTooLarge;
  const std::uint64_t row_bytes = std::uint64_t{message.width} * message.point_step;
  // Writers of clouds of one row do not always fill row_step in.
  const std::uint64_t row_step = message.height == 1 ? row_bytes : message.row_step;
  if (row_step < row_bytes || row_step * (message.height - 1) + row_bytes > message.data._length) {
    return MessageCause::kBadCloudLayout;
  }
  const FieldReader x(message, "x", {kFloat32, kFloat64});
  const FieldReader y(message, "y", {kFloat32, kFloat64});
  const FieldReader z(message, "z", {kFloat32, kFloat64});
  if (!x || !y || !z) return MessageCause::kMissingCloudFields;
  const FieldReader t(message, "t", {kUint32});
  const FieldReader ring(message, "ring", {kUint8, kUint16});
  const FieldReader range(message, "range", {kUint32});

  num_rows_ = static_cast<int>(message.height);
  num_columns_ = static_cast<int>(message.width);
  points_L_.resize(num_points);
  offset_ns_.resize(t ? num_points : 0);
  ring_.resize(ring ? num_points : 0);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::size_t i = 0;
  for (std::uint32_t row = 0; row < message.height; ++row) {
    const std::uint8_t* point = message.data._buffer + row * row_step;
    for (std::uint32_t column = 0; column < message.width; ++column) {
      Eigen::Vector3f p_L(x.number(point), y.number(point), z.number(point));
      const bool is_miss = !p_L.allFinite() || p_L.isZero(0) || (range && range.count(point) == 0);
      points_L_[i] = is_miss ? Eigen::Vector3f::Constant(kNan) : p_L;
      if (t) offset_ns_[i] = t.count(point);
      if (ring) ring_[i] = static_cast<std::uint16_t>(ring.count(point));
      point += message.point_step;
      ++i;
    }
  }
  return std::nullopt;
}

bool PointCloudDecoder::rows_are_beams() const {
  if (ring_.empty()) return true;
  for (int row = 0; row < num_rows_; ++row) {
    for (int column = 0; column < num_columns_; ++column) {
      const std::size_t pixel = static_cast<std::size_t>(row) * num_columns_ + column;
      if (!std::isnan(points_L_[pixel].x()) && ring_[pixel] != row) return false;
    }
  }
  return true;
}

bool PointCloudDecoder::find_first_columns() {
  const auto at = [this](int row, int column) {
    return offset_ns_[static_cast<std::size_t>(row) * num_columns_ + column % num_columns_];
  };
  std::vector<int> first;
  for (int row = 0; row < num_rows_; ++row) {
    const auto begin = offset_ns_.begin() + static_cast<std::ptrdiff_t>(row) * num_columns_;
    first.push_back(static_cast<int>(std::min_element(begin, begin + num_columns_) - begin));
    for (int column = 0; column < num_columns_; ++column) {
      const std::uint32_t offset = at(row, first.back() + column);
      if (offset != at(0, first.front() + column)) return false;
      // With every column there, stamps rise all the way.
      if (column > 0 && offset <= at(row, first.back() + column - 1)) return false;
    }
  }
  first_column_ = std::move(first);
  return true;
}

void PointCloudDecoder::learn() {
  if (table_rows_ != num_rows_ || table_columns_ != num_columns_) {
    table_rows_ = num_rows_;
    table_columns_ = num_columns_;
    fit_.emplace(num_rows_, num_columns_);
    num_clouds_in_fit_ = 0;
    first_column_.clear();
    row_is_known_.clear();
  }
  if (num_clouds_in_fit_ >= kMaxCloudsInFit || tables_.size() >= kMaxTables) return;
  if (first_column_.empty() && !find_first_columns()) return;
  const auto num_unknown = std::ranges::count(row_is_known_, 0);
  if (!row_is_known_.empty() && num_unknown == 0) return;
  fit_->add(points_L_);
  ++num_clouds_in_fit_;
  // Anew only for half of the rows that are still open, so that tables do not pile up.
  const int num_open = num_rows_ - fit_->num_known_rows();
  if (!row_is_known_.empty() && num_open > num_unknown / 2) return;
  auto table = fit_->geometry(first_column_);
  if (table == nullptr) return;
  tables_.push_back(std::move(table));
  row_is_known_.clear();
  for (int row = 0; row < num_rows_; ++row) row_is_known_.push_back(fit_->is_known(row));
}

bool PointCloudDecoder::fill_organised(SensorTime stamp, MessageCounters& counters,
                                       Scan& scan) const {
  if (row_is_known_.empty()) return false;
  const ScanGeometry& table = *tables_.back();
  scan.kind = Scan::Kind::kOrganised;
  scan.geometry = &table;
  scan.points_L.clear();
  scan.ranges_mm.assign(points_L_.size(), 0);
  scan.column_stamps.assign(static_cast<std::size_t>(num_columns_), SensorTime{});
  scan.column_valid.assign(static_cast<std::size_t>(num_columns_), 0);
  std::int64_t num_returns = 0, num_misfits = 0, num_unknown = 0;
  for (int row = 0; row < num_rows_; ++row) {
    for (int fired = 0; fired < num_columns_; ++fired) {
      const int column = (fired + first_column_[static_cast<std::size_t>(row)]) % num_columns_;
      const std::size_t pixel = static_cast<std::size_t>(row) * num_columns_ + column;
      const bool is_return = !std::isnan(points_L_[pixel].x());
      // A column that never arrived has neither returns nor a time.
      if (is_return || offset_ns_[pixel] > 0) {
        scan.column_valid[fired] = 1;
        scan.column_stamps[fired] = stamp + Duration{offset_ns_[pixel]};
      }
      if (!is_return) continue;
      ++num_returns;
      if (!row_is_known_[static_cast<std::size_t>(row)]) {
        ++num_unknown;
        continue;
      }
      const std::size_t target = static_cast<std::size_t>(row) * num_columns_ + fired;
      const Eigen::Vector3f beam = points_L_[pixel] - table.origin_L[target];
      const float range_m = beam.dot(table.direction_L[target]);
      const float miss_m = (beam - range_m * table.direction_L[target]).norm();
      if (!(range_m > 0 && range_m < kMaxRange_m &&
            miss_m <= kMaxMiss_m + kMaxMissShare * range_m)) {
        ++num_misfits;
        continue;
      }
      scan.ranges_mm[target] = static_cast<std::uint32_t>(std::lround(1000.0f * range_m));
    }
  }
  if (num_misfits * kMaxMisfitShare > num_returns) {
    counters.add(MessageCause::kBeamTableMismatch);
    return false;
  }
  counters.add(MessageCause::kReturnOfUnknownBeam, static_cast<std::uint64_t>(num_unknown));
  scan.stamp = stamp;
  for (int column = 0; column < num_columns_; ++column) {
    if (scan.column_valid[column]) scan.stamp = std::max(scan.stamp, scan.column_stamps[column]);
  }
  return true;
}

bool PointCloudDecoder::scan(const PointCloud2& message, MessageCounters& counters, Scan& scan) {
  const auto stamp = stamp_of(message.header.stamp);
  if (!stamp) {
    counters.add(MessageCause::kBadStamp);
    return false;
  }
  if (has_begun_ && frame_ != frame_name(message.header.frame_id)) {
    counters.add(MessageCause::kChangedFrame);
    return false;
  }
  if (const auto cause = read(message)) {
    counters.add(*cause);
    return false;
  }
  if (!has_begun_) {
    has_begun_ = true;
    frame_ = frame_name(message.header.frame_id);
  }
  bool is_organised = false;
  if (!clouds_only_ && is_image_of_turn(num_rows_, num_columns_) && !offset_ns_.empty() &&
      rows_are_beams()) {
    const std::size_t num_tables = tables_.size();
    learn();
    counters.add(MessageCause::kBeamTable, tables_.size() - num_tables);
    is_organised = fill_organised(*stamp, counters, scan);
  }
  counters.add(is_organised ? MessageCause::kOrganisedCloud : MessageCause::kUnorganisedCloud);
  if (!is_organised) {
    scan.kind = Scan::Kind::kCloud;
    scan.geometry = nullptr;
    scan.ranges_mm.clear();
    scan.column_stamps.clear();
    scan.column_valid.clear();
    scan.points_L.clear();
    std::ranges::copy_if(points_L_, std::back_inserter(scan.points_L),
                         [](const Eigen::Vector3f& p_L) { return !std::isnan(p_L.x()); });
    scan.stamp = *stamp;
  }
  scan.last_packet = scan.stamp;
  return true;
}

}  // namespace cloister::ros2
