#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware_interface/ouster/counters.hpp"
#include "firmware_interface/ouster/packet_decoder.hpp"
#include "firmware_interface/ouster/sensor_metadata.hpp"
#include "firmware_interface/ouster/udp_datagram.hpp"
#include "mapping/core/time.hpp"
#include "mapping/scan/scan.hpp"

namespace cloister {

/// What became of a sensor's datagrams, columns and scans.
enum class StreamCause {
  // datagrams
  kLidarPackets,
  kImuPackets,
  kWrongPort,
  kWrongSize,
  kWrongType,
  kImplausiblePacket,
  kEmptyPacket,
  kOtherSensor,
  kWrongInitId,
  kStalePacket,
  kUnexpectedFrameId,
  // columns
  kColumnOutOfRange,
  kColumnOutsideWindow,
  kDuplicateColumn,
  kInvalidColumn,
  kLostColumn,
  // scans
  kCompleteScan,
  kIncompleteScan,
  kEmptyScan,
  kUntakenScan,
  kSkippedFrame,
  kRestart,
  kCount,
};

constexpr std::array<CounterName, 22> counter_names(StreamCause) {
  return {{{"lidar_packets"},
           {"imu_packets"},
           {"wrong_port", true},
           {"wrong_size", true},
           {"wrong_type", true},
           {"implausible_packet", true},  // garbage before a sensor has been found to follow
           {"empty_packet", true},        // without a valid column, and of no open frame
           {"other_sensor", true},
           {"wrong_init_id", true},  // our sensor, but set up anew since the metadata was written
           {"stale_packet", true},   // of a frame that has been closed, or repeated after its end
           {"unexpected_frame_id", true},  // so far ahead that one packet alone is not believed
           {"column_out_of_range", true},
           {"column_outside_window", true},
           {"duplicate_column", true},
           {"invalid_column", true},  // marked invalid by the sensor
           {"lost_column", true},     // missing when its frame was closed
           {"complete_scans"},
           {"incomplete_scans", true},
           {"empty_scan", true},
           {"untaken_scan", true},
           {"skipped_frames"},
           {"stream_restarts"}}};
}

/// Puts the lidar packets of one sensor together into scans.
///
/// Whose packet: where packets carry a serial number and the metadata states one, it decides, and
/// the init id after it. Else the first plausible packet does: its source address (and serial
/// number) are followed from then on.
///
/// Which frame: by frame id, with wrap-around. Two frames are open at once: the newest, and the one
/// before it for packets that arrive late. A frame is closed as soon as every column of its window
/// has arrived; else when the next one has an eighth of its columns, or is a whole revolution later
/// by its stamps, or a third one begins. Scans leave in the order of their frames.
///
/// Frame ids that do not fit: steps ahead are frames that the sensor or the network left out; a
/// leap of more than `kMaxSkippedFrames` needs a second packet to be believed. Older ids are stale,
/// unless nothing but stale packets arrives for half a frame: then the sensor has been restarted
/// and its new count is followed.
///
/// Which column: by measurement id. A column is taken once: later copies are counted and dropped.
/// One that the sensor marks invalid counts as arrived, and gives way to a valid copy.
///
/// A scan's `stamp` is that of its last valid column. Scans without a valid column do not leave.
///
/// Threads: one at a time. Real-time: no allocation, lock or system call after construction;
/// O(packet) per push.
class ScanAssembler {
 public:
  static constexpr std::int32_t kMaxSkippedFrames = 1000;

  explicit ScanAssembler(const SensorMetadata& metadata);

  /// Takes in one datagram, whatever it is; every loss is counted under its cause.
  /// @return true when at least one scan can be taken. At most three scans wait: take them before
  ///         the next push, or the oldest is dropped and counted.
  bool push(const UdpDatagram& datagram);

  /// Closes the frames that are still open: the stream has ended or fallen silent.
  /// @return true when at least one scan can be taken
  bool flush();

  /// Copies the oldest finished scan into `scan`: kind, index, stamps, ranges and columns, no
  /// geometry and no poses. Does not allocate when `scan` has been reserved for this sensor's
  /// pixels and columns. `scan.last_packet` is the newest column stamp that had been seen when the
  /// scan was closed.
  /// @return false when none is waiting; `scan` is then unchanged
  bool take(Scan& scan);

  [[nodiscard]] int num_beams() const { return num_beams_; }
  [[nodiscard]] int num_columns() const { return num_columns_; }
  [[nodiscard]] const Counters<StreamCause>& counters() const { return counters_; }

 private:
  static constexpr int kNone = -1;
  // What one push can close: both open frames, and the one it completes.
  static constexpr int kMaxWaiting = 3;
  static constexpr int kNumFrames = kMaxWaiting + 2;

  struct Frame {
    std::uint32_t id = 0;
    int num_arrived = 0;
    int num_valid = 0;
    SensorTime last;                           // newest stamp of its valid columns
    SensorTime closed;                         // newest stamp of the stream when it was closed
    std::vector<std::uint32_t> ranges_mm;      // [num_beams x num_columns]
    std::vector<SensorTime> column_stamps;     // [num_columns]
    std::vector<std::uint8_t> column_valid;    // [num_columns]
    std::vector<std::uint8_t> column_arrived;  // [num_columns], valid or not
  };

  void push_lidar(const UdpDatagram& datagram);
  bool is_ours(const UdpDatagram& datagram, const PacketHeader& header);
  bool is_plausible() const;
  bool has_valid_column() const;
  int frame_for(std::uint32_t frame_id);
  int open_frame(std::uint32_t frame_id);
  void fill(Frame& frame, std::span<const std::byte> packet);
  void close_where_due();
  void close(int& frame_idx);
  int free_frame();

  PacketDecoder decoder_;
  int num_beams_;
  int num_columns_;
  ColumnWindow window_;
  int window_columns_;
  Duration period_;
  std::uint16_t lidar_port_;
  std::uint16_t imu_port_;
  std::uint64_t serial_number_;
  std::uint32_t init_id_;

  bool is_locked_ = false;
  std::uint32_t locked_address_ = 0;
  std::uint64_t locked_serial_ = 0;

  std::array<Frame, kNumFrames> frames_;
  int newest_ = kNone;    // index of the newest open frame
  int previous_ = kNone;  // index of the open frame before it
  bool has_begun_ = false;
  std::uint32_t newest_id_ = 0;  // newest frame id, open or closed
  int unexpected_run_ = 0;       // packets in a row whose frame id did not fit

  std::array<int, kMaxWaiting> waiting_{};  // finished frames, oldest first
  int num_waiting_ = 0;
  std::uint64_t next_scan_ = 0;

  std::vector<ColumnHeader> columns_;  // of the packet at hand
  std::vector<int> packet_columns_;    // scratch of fill(): columns of the packet to be copied
  std::vector<int> scan_columns_;      // scratch of fill(): where they go
  Counters<StreamCause> counters_;
};

}  // namespace cloister
