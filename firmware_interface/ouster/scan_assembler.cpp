#include "firmware_interface/ouster/scan_assembler.hpp"

#include <algorithm>
#include <utility>

namespace cloister {
namespace {

// A packet is late by a few others at most: a frame is done once 1/8 of the next one is here.
constexpr int kLateShare = 8;

}  // namespace

ScanAssembler::ScanAssembler(const SensorMetadata& metadata)
    : decoder_(metadata.profile, metadata.num_beams, metadata.columns_per_packet),
      num_beams_(metadata.num_beams),
      num_columns_(metadata.num_columns),
      window_(metadata.column_window),
      window_columns_(window_.num_columns(num_columns_)),
      period_{1'000'000'000 / metadata.rate_hz},
      lidar_port_(metadata.lidar_port),
      imu_port_(metadata.imu_port),
      serial_number_(metadata.serial_number),
      init_id_(metadata.init_id) {
  const auto columns = static_cast<std::size_t>(num_columns_);
  for (Frame& frame : frames_) {
    frame.ranges_mm.resize(columns * static_cast<std::size_t>(num_beams_));
    frame.column_stamps.resize(columns);
    frame.column_valid.resize(columns);
    frame.column_arrived.resize(columns);
  }
  columns_.resize(static_cast<std::size_t>(metadata.columns_per_packet));
  packet_columns_.reserve(static_cast<std::size_t>(metadata.columns_per_packet));
  scan_columns_.reserve(static_cast<std::size_t>(metadata.columns_per_packet));
}

bool ScanAssembler::push(const UdpDatagram& datagram) {
  const std::span<const std::byte> packet = datagram.payload;
  if (datagram.destination_port != lidar_port_) {
    counters_.add(datagram.destination_port == imu_port_ ? StreamCause::kImuPackets
                                                         : StreamCause::kWrongPort);
  } else if (packet.size() != decoder_.packet_bytes()) {
    counters_.add(packet.size() == kImuPacketBytes ? StreamCause::kImuPackets
                                                   : StreamCause::kWrongSize);
  } else {
    push_lidar(datagram);
  }
  return num_waiting_ > 0;
}

void ScanAssembler::push_lidar(const UdpDatagram& datagram) {
  const std::span<const std::byte> packet = datagram.payload;
  const PacketHeader header = decoder_.header(packet);
  for (int i = 0; i < decoder_.columns_per_packet(); ++i) {
    columns_[static_cast<std::size_t>(i)] = decoder_.column(packet, i);
  }
  if (!is_ours(datagram, header)) return;
  counters_.add(StreamCause::kLidarPackets);
  if (const int frame_idx = frame_for(header.frame_id); frame_idx != kNone) {
    fill(frames_[static_cast<std::size_t>(frame_idx)], packet);
    close_where_due();
  }
}

bool ScanAssembler::is_ours(const UdpDatagram& datagram, const PacketHeader& header) {
  if (!header.is_lidar) {
    counters_.add(StreamCause::kWrongType);
    return false;
  }
  if (serial_number_ != 0 && header.serial_number != 0) {
    if (header.serial_number != serial_number_) {
      counters_.add(StreamCause::kOtherSensor);
      return false;
    }
    if (init_id_ != 0 && header.init_id != init_id_) {
      counters_.add(StreamCause::kWrongInitId);
      return false;
    }
    return true;
  }
  if (!is_locked_) {
    if (!is_plausible()) {
      counters_.add(StreamCause::kImplausiblePacket);
      return false;
    }
    is_locked_ = true;
    locked_address_ = datagram.source_address;
    locked_serial_ = header.serial_number;
  }
  if (datagram.source_address != locked_address_ || header.serial_number != locked_serial_) {
    counters_.add(StreamCause::kOtherSensor);
    return false;
  }
  return true;
}

// A sensor's packet holds neighbouring columns in the order they were fired,
// at least one of them valid.
bool ScanAssembler::is_plausible() const {
  int expected_id = columns_.front().measurement_id;
  SensorTime last;
  for (const ColumnHeader& column : columns_) {
    if (column.valid && (column.measurement_id != expected_id || column.stamp < last)) return false;
    if (column.valid) last = column.stamp;
    ++expected_id;
  }
  return has_valid_column();
}

bool ScanAssembler::has_valid_column() const {
  return std::any_of(columns_.begin(), columns_.end(), [this](const ColumnHeader& column) {
    return column.valid && column.measurement_id < num_columns_ &&
           window_.contains(column.measurement_id);
  });
}

int ScanAssembler::frame_for(std::uint32_t frame_id) {
  // Distance from the newest frame id, in the width that the profile counts in: positive is ahead.
  const bool is_wide = decoder_.layout().frame_id.bytes == 4;
  const std::uint32_t difference = frame_id - newest_id_;
  const std::int32_t ahead =
      is_wide ? static_cast<std::int32_t>(difference) : static_cast<std::int16_t>(difference);
  if (has_begun_ && ahead == 0 && newest_ != kNone) {
    unexpected_run_ = 0;
    return newest_;
  }
  if (previous_ != kNone && frames_[static_cast<std::size_t>(previous_)].id == frame_id) {
    unexpected_run_ = 0;
    return previous_;
  }
  if (!has_valid_column()) {
    counters_.add(StreamCause::kEmptyPacket);
    return kNone;
  }
  if (!has_begun_) return open_frame(frame_id);
  if (ahead == 0) {
    counters_.add(StreamCause::kStalePacket);
    return kNone;
  }
  if (ahead > 0 && ahead <= kMaxSkippedFrames + 1) {
    counters_.add(StreamCause::kSkippedFrame, static_cast<std::uint64_t>(ahead - 1));
    return open_frame(frame_id);
  }
  const int half_frame = window_columns_ / decoder_.columns_per_packet() / 2;
  const int patience = ahead > 0 ? 2 : std::max(2, half_frame);
  if (++unexpected_run_ < patience) {
    counters_.add(ahead > 0 ? StreamCause::kUnexpectedFrameId : StreamCause::kStalePacket);
    return kNone;
  }
  counters_.add(StreamCause::kRestart);
  close(previous_);
  close(newest_);
  return open_frame(frame_id);
}

int ScanAssembler::open_frame(std::uint32_t frame_id) {
  close(previous_);
  previous_ = newest_;
  newest_ = free_frame();
  newest_id_ = frame_id;
  has_begun_ = true;
  unexpected_run_ = 0;
  Frame& frame = frames_[static_cast<std::size_t>(newest_)];
  frame.id = frame_id;
  frame.num_arrived = 0;
  frame.num_valid = 0;
  frame.last = {};
  std::fill(frame.ranges_mm.begin(), frame.ranges_mm.end(), 0U);
  std::fill(frame.column_stamps.begin(), frame.column_stamps.end(), SensorTime{});
  std::fill(frame.column_valid.begin(), frame.column_valid.end(), std::uint8_t{0});
  std::fill(frame.column_arrived.begin(), frame.column_arrived.end(), std::uint8_t{0});
  return newest_;
}

void ScanAssembler::fill(Frame& frame, std::span<const std::byte> packet) {
  packet_columns_.clear();
  scan_columns_.clear();
  for (int i = 0; i < decoder_.columns_per_packet(); ++i) {
    const ColumnHeader& column = columns_[static_cast<std::size_t>(i)];
    if (column.measurement_id >= num_columns_) {
      counters_.add(StreamCause::kColumnOutOfRange);
      continue;
    }
    if (!window_.contains(column.measurement_id)) {
      counters_.add(StreamCause::kColumnOutsideWindow);
      continue;
    }
    const auto target = static_cast<std::size_t>(column.measurement_id);
    const bool has_arrived = frame.column_arrived[target] != 0;
    if (frame.column_valid[target] != 0 || (has_arrived && !column.valid)) {
      counters_.add(StreamCause::kDuplicateColumn);
      continue;
    }
    frame.column_arrived[target] = 1;
    frame.num_arrived += has_arrived ? 0 : 1;
    if (!column.valid) {
      counters_.add(StreamCause::kInvalidColumn);
      continue;
    }
    frame.column_valid[target] = 1;
    frame.column_stamps[target] = column.stamp;
    frame.last = frame.num_valid == 0 ? column.stamp : std::max(frame.last, column.stamp);
    ++frame.num_valid;
    packet_columns_.push_back(i);
    scan_columns_.push_back(column.measurement_id);
  }
  decoder_.copy_ranges(packet, packet_columns_, scan_columns_, num_columns_, frame.ranges_mm);
}

void ScanAssembler::close_where_due() {
  if (previous_ != kNone) {
    const Frame& previous = frames_[static_cast<std::size_t>(previous_)];
    const Frame& newest = frames_[static_cast<std::size_t>(newest_)];
    const bool is_overtaken = newest.num_arrived * kLateShare >= window_columns_;
    const bool is_long_ago =
        previous.num_valid > 0 && newest.num_valid > 0 && newest.last - previous.last > period_;
    if (previous.num_arrived == window_columns_ || is_overtaken || is_long_ago) close(previous_);
  }
  if (newest_ != kNone &&
      frames_[static_cast<std::size_t>(newest_)].num_arrived == window_columns_) {
    close(previous_);
    close(newest_);
  }
}

void ScanAssembler::close(int& frame_idx) {
  if (frame_idx == kNone) return;
  const int closed = std::exchange(frame_idx, kNone);
  Frame& frame = frames_[static_cast<std::size_t>(closed)];
  const bool is_complete = frame.num_arrived == window_columns_;
  counters_.add(is_complete ? StreamCause::kCompleteScan : StreamCause::kIncompleteScan);
  counters_.add(StreamCause::kLostColumn,
                static_cast<std::uint64_t>(window_columns_ - frame.num_arrived));
  if (frame.num_valid == 0) return counters_.add(StreamCause::kEmptyScan);
  if (num_waiting_ == kMaxWaiting) {
    counters_.add(StreamCause::kUntakenScan);
    std::shift_left(waiting_.begin(), waiting_.end(), 1);
    --num_waiting_;
  }
  frame.closed = frame.last;
  if (newest_ != kNone) {
    frame.closed = std::max(frame.last, frames_[static_cast<std::size_t>(newest_)].last);
  }
  waiting_[static_cast<std::size_t>(num_waiting_++)] = closed;
}

// Two open, three waiting, five in all: as opening closes one first, there is always a free one.
int ScanAssembler::free_frame() {
  const auto is_waiting = [this](int frame_idx) {
    return std::find(waiting_.begin(), waiting_.begin() + num_waiting_, frame_idx) !=
           waiting_.begin() + num_waiting_;
  };
  int frame_idx = 0;
  while (frame_idx == previous_ || frame_idx == newest_ || is_waiting(frame_idx)) ++frame_idx;
  return frame_idx;
}

bool ScanAssembler::flush() {
  close(previous_);
  close(newest_);
  return num_waiting_ > 0;
}

bool ScanAssembler::take(Scan& scan) {
  if (num_waiting_ == 0) return false;
  const Frame& frame = frames_[static_cast<std::size_t>(waiting_[0])];
  scan.kind = Scan::Kind::kOrganised;
  scan.index = next_scan_++;
  scan.stamp = frame.last;
  scan.last_packet = frame.closed;
  scan.ranges_mm.assign(frame.ranges_mm.begin(), frame.ranges_mm.end());
  scan.column_stamps.assign(frame.column_stamps.begin(), frame.column_stamps.end());
  scan.column_valid.assign(frame.column_valid.begin(), frame.column_valid.end());
  scan.points_L.clear();
  std::shift_left(waiting_.begin(), waiting_.begin() + num_waiting_, 1);
  --num_waiting_;
  return true;
}

}  // namespace cloister
