#include "firmware_interface/ouster/scan_assembler.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "test/support/lidar_packet.hpp"

using namespace cloister;
using cloister::testing::Bytes;
using cloister::testing::encode;
using cloister::testing::LidarPacket;

namespace {

using Counts = std::map<std::string, std::uint64_t>;

constexpr std::int64_t kPeriodNs = 100'000'000;
constexpr std::int64_t kColumnNs = kPeriodNs / 512;
constexpr int kPackets = 32;  // per frame of 512 columns

SensorMetadata sensor(UdpProfile profile = UdpProfile::kLegacy) {
  SensorMetadata metadata;
  metadata.num_columns = 512;
  metadata.rate_hz = 10;
  metadata.num_beams = 16;
  metadata.beam_altitude_rad.assign(16, 0.0);
  metadata.beam_azimuth_rad.assign(16, 0.0);
  metadata.pixel_shift.assign(16, 0);
  metadata.column_window = {0, 511};
  metadata.profile = profile;
  return metadata;
}

// A range that tells frame, column and beam, in steps of eight so that every profile can say it.
std::uint32_t range_mm(std::uint32_t frame, int beam, int column) {
  return 8 * (1 + (frame % 5) * 600 + static_cast<std::uint32_t>(column + beam));
}

// A stream of packets as the sensor would send them; frames are counted from 0, whatever their ids.
class Stream {
 public:
  explicit Stream(const SensorMetadata& metadata = sensor()) : assembler(metadata) {
    profile_ = packet_layout(metadata.profile).name;
  }

  LidarPacket packet(int frame, int packet_idx) const {
    LidarPacket packet;
    packet.profile = profile_;
    packet.frame_id = first_frame_id + static_cast<std::uint32_t>(frame);
    packet.first_measurement_id = 16 * packet_idx;
    packet.first_stamp_ns =
        static_cast<std::uint64_t>(1'000'000'000 + frame * kPeriodNs + 16 * packet_idx * kColumnNs);
    packet.column_step_ns = kColumnNs;
    packet.serial_number = serial_number;
    packet.init_id = init_id;
    const std::uint32_t step =
        packet_layout(*find_udp_profile(profile_)).range_mm.bytes == 2 ? 8 : 1;
    packet.range = [frame, packet_idx, step](int beam, int column) {
      return range_mm(static_cast<std::uint32_t>(frame), beam, 16 * packet_idx + column) / step;
    };
    return packet;
  }

  void push(const Bytes& payload, std::uint32_t address = 1, int port = 7502) {
    UdpDatagram datagram;
    datagram.source_address = address;
    datagram.destination_port = static_cast<std::uint16_t>(port);
    datagram.payload = payload;
    if (assembler.push(datagram)) take_all();
  }
  void push(int frame, int packet_idx) { push(encode(packet(frame, packet_idx))); }
  void push_frame(int frame, int first = 0, int last = kPackets - 1) {
    for (int i = first; i <= last; ++i) push(frame, i);
  }
  void flush() {
    if (assembler.flush()) take_all();
  }

  Counts counts() const {
    Counts counts = assembler.counters().all();
    std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
    return counts;
  }

  std::uint32_t first_frame_id = 100;
  std::uint64_t serial_number = 0;
  std::uint32_t init_id = 0;
  ScanAssembler assembler;
  std::vector<Scan> scans;

 private:
  void take_all() {
    Scan scan;
    while (assembler.take(scan)) scans.push_back(scan);
  }

  std::string profile_;
};

int valid_columns_of(const Scan& scan) {
  return static_cast<int>(std::count(scan.column_valid.begin(), scan.column_valid.end(), 1));
}

// Every valid column holds the frame's ranges and stamps, every other one nothing.
void check_content(const Scan& scan, int frame) {
  bool ranges_right = true;
  bool stamps_right = true;
  for (int column = 0; column < 512; ++column) {
    const bool valid = scan.column_valid[column] == 1;
    if (valid) {
      stamps_right &=
          scan.column_stamps[column].ns == 1'000'000'000 + frame * kPeriodNs + column * kColumnNs;
    }
    for (int beam = 0; beam < 16; ++beam) {
      const std::uint32_t expected =
          valid ? range_mm(static_cast<std::uint32_t>(frame), beam, column) : 0;
      ranges_right &= scan.ranges_mm[beam * 512 + column] == expected;
    }
  }
  CHECK(ranges_right);
  CHECK(stamps_right);
}

std::int64_t stamp_ns(int frame, int column) {
  return 1'000'000'000 + frame * kPeriodNs + column * kColumnNs;
}

}  // namespace

TEST_CASE("a scan is complete with its last packet, in every profile") {
  for (const PacketLayout& layout : kPacketLayouts) {
    CAPTURE(std::string(layout.name));
    Stream stream(sensor(layout.profile));
    stream.push_frame(0, 0, kPackets - 2);
    CHECK(stream.scans.empty());
    stream.push(0, kPackets - 1);
    REQUIRE(stream.scans.size() == 1);
    CHECK(stream.scans[0].kind == Scan::Kind::kOrganised);
    CHECK(stream.scans[0].index == 0);
    CHECK(stream.scans[0].stamp.ns == stamp_ns(0, 511));
    CHECK(stream.scans[0].last_packet == stream.scans[0].stamp);
    CHECK(valid_columns_of(stream.scans[0]) == 512);
    check_content(stream.scans[0], 0);
    CHECK(stream.counts() == Counts{{"complete_scans", 1}, {"lidar_packets", 32}});
  }
}

TEST_CASE("frame ids wrap around") {
  for (const UdpProfile profile : {UdpProfile::kLegacy, UdpProfile::kFusaRng15Rfl8Nir8Dual}) {
    Stream stream(sensor(profile));
    stream.first_frame_id = profile == UdpProfile::kLegacy ? 0xfffe : 0xfffffffe;
    for (int frame = 0; frame < 4; ++frame) stream.push_frame(frame);
    REQUIRE(stream.scans.size() == 4);
    for (int frame = 0; frame < 4; ++frame) check_content(stream.scans[frame], frame);
    CHECK(stream.counts() == Counts{{"complete_scans", 4}, {"lidar_packets", 128}});
  }
}

TEST_CASE("packets may arrive in any order within a frame") {
  std::mt19937 random(3);
  Stream stream;
  std::vector<int> order(kPackets);
  std::iota(order.begin(), order.end(), 0);
  for (int frame = 0; frame < 5; ++frame) {
    std::shuffle(order.begin(), order.end(), random);
    for (const int packet : order) stream.push(frame, packet);
  }
  REQUIRE(stream.scans.size() == 5);
  for (int frame = 0; frame < 5; ++frame) check_content(stream.scans[frame], frame);
}

TEST_CASE("a packet that is late by a few still joins its frame, and scans keep their order") {
  Stream stream;
  stream.push_frame(0, 0, 29);
  stream.push(1, 0);
  stream.push(0, 31);
  stream.push(1, 1);
  stream.push(0, 30);
  CHECK(stream.scans.size() == 1);
  stream.push_frame(1, 2);
  REQUIRE(stream.scans.size() == 2);
  check_content(stream.scans[0], 0);
  check_content(stream.scans[1], 1);
  CHECK(stream.scans[0].last_packet.ns == stamp_ns(1, 31));
  CHECK(stream.counts() == Counts{{"complete_scans", 2}, {"lidar_packets", 64}});
}

TEST_CASE("a frame that misses packets is closed when the next one is well under way") {
  Stream stream;
  stream.push_frame(0, 0, 10);
  stream.push_frame(0, 13, 31);
  stream.push_frame(1, 0, 2);
  CHECK(stream.scans.empty());
  stream.push(1, 3);
  REQUIRE(stream.scans.size() == 1);
  CHECK(valid_columns_of(stream.scans[0]) == 480);
  check_content(stream.scans[0], 0);
  CHECK(stream.scans[0].stamp.ns == stamp_ns(0, 511));
  stream.push(0, 11);
  CHECK(stream.counts() == Counts{{"incomplete_scans", 1},
                                  {"lidar_packets", 35},
                                  {"lost_column", 32},
                                  {"stale_packet", 1}});
}

TEST_CASE("a frame that stopped is closed by the first packet of a much later one") {
  Stream stream;
  stream.push_frame(0, 0, 15);
  stream.push(5, 0);
  REQUIRE(stream.scans.size() == 1);
  CHECK(valid_columns_of(stream.scans[0]) == 256);
  CHECK(stream.scans[0].stamp.ns == stamp_ns(0, 255));
  CHECK(stream.scans[0].last_packet.ns == stamp_ns(5, 15));
  CHECK(stream.counts()["skipped_frames"] == 4);
}

TEST_CASE("what is open when the stream ends is handed out") {
  Stream stream;
  stream.push_frame(0, 0, 30);
  stream.push(1, 0);
  CHECK(stream.scans.empty());
  stream.flush();
  REQUIRE(stream.scans.size() == 2);
  CHECK(valid_columns_of(stream.scans[0]) == 496);
  CHECK(valid_columns_of(stream.scans[1]) == 16);
  stream.flush();
  CHECK(stream.scans.size() == 2);
}

TEST_CASE("repeated packets change nothing and are counted") {
  Stream stream;
  for (int i = 0; i < kPackets; ++i) {
    stream.push(0, i);
    stream.push(0, i);
  }
  REQUIRE(stream.scans.size() == 1);
  check_content(stream.scans[0], 0);
  CHECK(stream.counts() == Counts{{"complete_scans", 1},
                                  {"duplicate_column", 31 * 16},
                                  {"lidar_packets", 64},
                                  {"stale_packet", 1}});
}

TEST_CASE("only every fifth frame need be there") {
  Stream stream;
  for (int frame = 0; frame < 20; frame += 5) stream.push_frame(frame);
  CHECK(stream.scans.size() == 4);
  CHECK(stream.counts() ==
        Counts{{"complete_scans", 4}, {"lidar_packets", 128}, {"skipped_frames", 12}});
}

TEST_CASE("one packet with a frame id far off costs no frame") {
  for (const std::uint32_t leap : {5'000U, 30'000U, 40'000U, 65'000U}) {
    CAPTURE(leap);
    Stream stream;
    stream.push_frame(0, 0, 15);
    LidarPacket stray = stream.packet(0, 16);
    stray.frame_id += leap;
    stream.push(encode(stray));
    stream.push_frame(0, 16, 31);
    stream.push_frame(1);
    REQUIRE(stream.scans.size() == 2);
    CHECK(stream.counts()["complete_scans"] == 2);
    CHECK(stream.counts()[leap < 32768 ? "unexpected_frame_id" : "stale_packet"] == 1);
  }
}

TEST_CASE("a sensor that begins to count anew is followed") {
  Stream stream;
  stream.first_frame_id = 5000;
  stream.push_frame(0);
  stream.first_frame_id = 0;
  for (int frame = 0; frame < 3; ++frame) stream.push_frame(frame);
  REQUIRE(stream.scans.size() == 4);
  CHECK(valid_columns_of(stream.scans[1]) == 512 - 15 * 16);
  CHECK(valid_columns_of(stream.scans[2]) == 512);
  CHECK(stream.counts()["stream_restarts"] == 1);
  CHECK(stream.counts()["stale_packet"] == 15);
}

TEST_CASE("a long gap in the frame ids costs one packet") {
  Stream stream;
  stream.push_frame(0);
  stream.push_frame(10'000);
  stream.push_frame(10'001);
  REQUIRE(stream.scans.size() == 3);
  CHECK(valid_columns_of(stream.scans[1]) == 496);
  CHECK(stream.counts()["unexpected_frame_id"] == 1);
}

TEST_CASE("columns marked invalid stay empty, and a valid copy takes their place") {
  Stream stream;
  for (int i = 0; i < kPackets; ++i) {
    LidarPacket packet = stream.packet(0, i);
    if (i == 4) packet.is_valid = [](int column) { return column != 7; };
    if (i != 9) stream.push(encode(packet));
  }
  stream.push(0, 4);
  LidarPacket packet = stream.packet(0, 9);
  packet.is_valid = [](int column) { return column != 7; };
  stream.push(encode(packet));
  REQUIRE(stream.scans.size() == 1);
  CHECK(valid_columns_of(stream.scans[0]) == 511);
  CHECK(stream.scans[0].column_valid[4 * 16 + 7] == 1);
  CHECK(stream.scans[0].column_valid[9 * 16 + 7] == 0);
  check_content(stream.scans[0], 0);
  CHECK(stream.counts() == Counts{{"complete_scans", 1},
                                  {"duplicate_column", 15},
                                  {"invalid_column", 2},
                                  {"lidar_packets", 33}});
}

TEST_CASE("packets without a valid column open no frame, and scans without one do not leave") {
  Stream stream;
  stream.push(0, 0);  // a plausible packet, so that the sensor is followed
  stream.push_frame(0, 1);
  for (int i = 0; i < kPackets; ++i) {
    LidarPacket packet = stream.packet(1, i);
    packet.is_valid = [](int) { return false; };
    stream.push(encode(packet));
  }
  stream.flush();
  CHECK(stream.scans.size() == 1);
  CHECK(stream.counts()["empty_packet"] == 32);
}

TEST_CASE("measurement ids beyond the revolution and outside the window are counted") {
  SensorMetadata metadata = sensor();
  metadata.column_window = {500, 9};
  Stream stream(metadata);
  stream.push(0, 0);
  stream.push(0, 5);
  LidarPacket packet = stream.packet(0, 32);
  stream.push(encode(packet));
  stream.push(0, 31);
  REQUIRE(stream.scans.size() == 1);
  CHECK(valid_columns_of(stream.scans[0]) == 22);
  CHECK(stream.scans[0].stamp.ns == stamp_ns(0, 511));
  check_content(stream.scans[0], 0);
  CHECK(stream.counts() == Counts{{"column_out_of_range", 16},
                                  {"column_outside_window", 6 + 16 + 4},
                                  {"complete_scans", 1},
                                  {"lidar_packets", 4}});
}

TEST_CASE("datagrams of other ports and sizes are counted, inertial ones on either port") {
  Stream stream;
  stream.push(Bytes(48), 1, 7503);
  stream.push(Bytes(48), 1, 7502);
  stream.push(Bytes(100), 1, 7502);
  stream.push(Bytes(), 1, 7502);
  Bytes longer = encode(stream.packet(0, 0));
  longer.push_back({});
  stream.push(longer);
  stream.push(encode(stream.packet(0, 0)), 1, 9999);
  CHECK(stream.counts() == Counts{{"imu_packets", 2}, {"wrong_port", 1}, {"wrong_size", 3}});
}

TEST_CASE("of two sensors that cannot be named the first plausible one is followed") {
  Stream stream;
  stream.push(Bytes(encode(stream.packet(0, 0)).size(), std::byte{0xff}), 7);
  LidarPacket shuffled = stream.packet(0, 3);
  Bytes bytes = encode(shuffled);
  bytes[8 + 2 * (16 + 12 * 16 + 4)] = std::byte{200};  // one column out of sequence
  stream.push(bytes, 7);
  for (int i = 0; i < kPackets; ++i) {
    stream.push(encode(stream.packet(0, i)), 2);
    stream.push(encode(stream.packet(3, i)), 7);
  }
  REQUIRE(stream.scans.size() == 1);
  check_content(stream.scans[0], 0);
  CHECK(stream.counts() == Counts{{"complete_scans", 1},
                                  {"implausible_packet", 2},
                                  {"lidar_packets", 32},
                                  {"other_sensor", 32}});
}

TEST_CASE("where packets name their sensor, the metadata's is followed from any address") {
  SensorMetadata metadata = sensor(UdpProfile::kRng19Rfl8Sig16Nir16);
  metadata.serial_number = 122'247'000'785;
  metadata.init_id = 77;
  Stream stream(metadata);
  stream.serial_number = 5;
  stream.push(0, 0);
  stream.serial_number = metadata.serial_number;
  stream.init_id = 76;
  stream.push(0, 0);
  stream.init_id = 77;
  for (int i = 0; i < kPackets; ++i) {
    stream.push(encode(stream.packet(0, i)), static_cast<std::uint32_t>(i % 2));
  }
  REQUIRE(stream.scans.size() == 1);
  CHECK(stream.counts() == Counts{{"complete_scans", 1},
                                  {"lidar_packets", 32},
                                  {"other_sensor", 1},
                                  {"wrong_init_id", 1}});
}

TEST_CASE("a packet that is not a lidar packet by its type is dropped") {
  Stream stream(sensor(UdpProfile::kRng15Rfl8Nir8));
  Bytes bytes = encode(stream.packet(0, 0));
  bytes[0] = std::byte{2};
  stream.push(bytes);
  CHECK(stream.counts() == Counts{{"wrong_type", 1}});
}

TEST_CASE("scans that nobody takes are dropped, oldest first, and counted") {
  Stream stream;
  for (int frame = 0; frame < 5; ++frame) {
    for (int i = 0; i < kPackets; ++i) {
      const Bytes bytes = encode(stream.packet(frame, i));
      UdpDatagram datagram;
      datagram.destination_port = 7502;
      datagram.payload = bytes;
      stream.assembler.push(datagram);
    }
  }
  stream.flush();
  REQUIRE(stream.scans.size() == 3);
  for (int i = 0; i < 3; ++i) check_content(stream.scans[i], 2 + i);
  CHECK(stream.counts()["untaken_scan"] == 2);
  Scan untouched;
  untouched.index = 42;
  CHECK_FALSE(stream.assembler.take(untouched));
  CHECK(untouched.index == 42);
}

TEST_CASE("taking a scan into a reserved slot does not grow it") {
  Stream stream;
  Scan slot;
  slot.reserve(16 * 512, 512, 4);
  const std::uint32_t* ranges = slot.ranges_mm.data();
  const SensorTime* stamps = slot.column_stamps.data();
  for (int i = 0; i < kPackets; ++i) {
    const Bytes bytes = encode(stream.packet(0, i));
    UdpDatagram datagram;
    datagram.destination_port = 7502;
    datagram.payload = bytes;
    stream.assembler.push(datagram);
  }
  REQUIRE(stream.assembler.take(slot));
  CHECK(slot.ranges_mm.data() == ranges);
  CHECK(slot.column_stamps.data() == stamps);
}

TEST_CASE("a noisy line loses what it loses, and every column is accounted for") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    Stream stream;
    stream.push(0, 0);
    std::uint64_t pushed = 1;
    for (int frame = 0; frame < 20; ++frame) {
      for (int i = frame == 0 ? 1 : 0; i < kPackets; ++i) {
        if (random() % 20 == 0) continue;
        Bytes bytes = encode(stream.packet(frame, i));
        if (random() % 10 == 0) {
          for (int flips = 0; flips < 4; ++flips) {
            bytes[random() % bytes.size()] = static_cast<std::byte>(random());
          }
        }
        const int copies = random() % 10 == 0 ? 2 : 1;
        for (int copy = 0; copy < copies; ++copy) stream.push(bytes);
        pushed += static_cast<std::uint64_t>(copies);
      }
    }
    stream.flush();
    std::uint64_t valid = 0;
    for (const Scan& scan : stream.scans) {
      valid += static_cast<std::uint64_t>(valid_columns_of(scan));
    }
    Counts counts = stream.counts();
    CHECK(counts["lidar_packets"] == pushed);
    const std::uint64_t dropped_packets =
        counts["stale_packet"] + counts["unexpected_frame_id"] + counts["empty_packet"];
    // A column that arrived invalid and valid later stands in both counts.
    CHECK(valid + counts["duplicate_column"] + counts["invalid_column"] +
              counts["column_out_of_range"] + 16 * dropped_packets ==
          16 * pushed);
    CHECK(stream.scans.size() >= 18);
    CHECK(valid > 16U * kPackets * 20 * 8 / 10);
  }
}
