// Every capture of test/data/ouster_captures, from file to scans,
// against published digests and exact counts.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "firmware_interface/files/read_file.hpp"
#include "firmware_interface/ouster/packet_decoder.hpp"
#include "firmware_interface/ouster/pcap_source.hpp"
#include "firmware_interface/ouster/scan_assembler.hpp"
#include "firmware_interface/ouster/sensor_metadata.hpp"
#include "test/support/md5.hpp"

using namespace cloister;
using cloister::testing::md5_of;

namespace {

const std::filesystem::path kCaptures =
    std::filesystem::path(CLOISTER_TEST_DATA) / "ouster_captures";

using Counts = std::map<std::string, std::uint64_t>;

struct Replay {
  std::vector<Scan> scans;
  Counts stream;  // all counters that are not zero
  Counts capture;
};

Counts nonzero(Counts counts) {
  std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
  return counts;
}

SensorMetadata metadata_of(const std::string& file) {
  Result<SensorMetadata> metadata = load_metadata(kCaptures / file);
  REQUIRE_MESSAGE(metadata.has_value(), metadata.error().message);
  return *metadata;
}

Replay replay(const std::string& pcap_file, const SensorMetadata& metadata) {
  Result<PcapSource> source = PcapSource::open(kCaptures / pcap_file);
  REQUIRE_MESSAGE(source.has_value(), source.error().message);
  ScanAssembler assembler(metadata);
  Replay result;
  const auto take_all = [&] {
    Scan scan;
    while (assembler.take(scan)) result.scans.push_back(scan);
  };
  UdpDatagram datagram;
  while (true) {
    const Result<bool> more = source->next(datagram);
    REQUIRE_MESSAGE(more.has_value(), more.error().message);
    if (!*more) break;
    if (assembler.push(datagram)) take_all();
  }
  if (assembler.flush()) take_all();
  CHECK_FALSE(source->warning().has_value());
  result.stream = nonzero(assembler.counters().all());
  result.capture = nonzero(source->counters().all());
  return result;
}

Replay replay(const std::string& pcap_file, const std::string& json_file) {
  return replay(pcap_file, metadata_of(json_file));
}

int returns_of(const Scan& scan) {
  return static_cast<int>(scan.ranges_mm.size() -
                          std::count(scan.ranges_mm.begin(), scan.ranges_mm.end(), 0U));
}

int valid_columns_of(const Scan& scan) {
  return static_cast<int>(std::count(scan.column_valid.begin(), scan.column_valid.end(), 1));
}

int first_valid_column_of(const Scan& scan) {
  return static_cast<int>(std::find(scan.column_valid.begin(), scan.column_valid.end(), 1) -
                          scan.column_valid.begin());
}

// Digests over all lidar packets of a capture, field by field as the packets hold them.
struct PacketDigests {
  std::string ranges;
  std::string reflectivities;
  std::string stamps;
  std::uint32_t frame_id = 0;  // of the last packet
  std::string measurement_ids;
};

PacketDigests packet_digests(const std::string& pcap_file, const SensorMetadata& metadata) {
  const PacketDecoder decoder(metadata.profile, metadata.num_beams, metadata.columns_per_packet);
  const PacketLayout& layout = decoder.layout();
  const int num_columns = metadata.columns_per_packet;
  std::vector<std::uint32_t> ranges;
  std::vector<std::uint8_t> reflectivities;
  std::vector<std::uint64_t> stamps;
  std::uint32_t frame_id = 0;
  std::vector<std::uint16_t> measurement_ids;
  std::vector<int> columns(static_cast<std::size_t>(num_columns));
  std::iota(columns.begin(), columns.end(), 0);
  std::vector<std::uint32_t> packet_ranges(
      static_cast<std::size_t>(metadata.num_beams * num_columns));

  Result<PcapSource> source = PcapSource::open(kCaptures / pcap_file);
  REQUIRE(source.has_value());
  UdpDatagram datagram;
  while (source->next(datagram) == true) {
    if (datagram.payload.size() != decoder.packet_bytes()) continue;
    frame_id = decoder.header(datagram.payload).frame_id;
    for (const int column : columns) {
      const ColumnHeader header = decoder.column(datagram.payload, column);
      stamps.push_back(static_cast<std::uint64_t>(header.stamp.ns));
      measurement_ids.push_back(static_cast<std::uint16_t>(header.measurement_id));
    }
    decoder.copy_ranges(datagram.payload, columns, columns, num_columns, packet_ranges);
    ranges.insert(ranges.end(), packet_ranges.begin(), packet_ranges.end());
    for (int beam = 0; beam < metadata.num_beams; ++beam) {
      for (const int column : columns) {
        const std::byte* pixel = datagram.payload.data() + layout.packet_header_bytes +
                                 column * layout.column_bytes(metadata.num_beams) +
                                 layout.column_header_bytes + beam * layout.pixel_bytes;
        reflectivities.push_back(static_cast<std::uint8_t>(layout.reflectivity.load(pixel)));
      }
    }
  }
  return {md5_of(ranges), md5_of(reflectivities), md5_of(stamps), frame_id,
          md5_of(measurement_ids)};
}

struct ExpectedScan {
  int valid_columns;
  int first_valid_column;
  int returns;
  std::int64_t stamp_ns;
};

struct Expected {
  std::string pcap_file;
  std::string json_file;
  Counts stream;
  Counts capture;
  std::vector<ExpectedScan> scans;
};

// Scans: valid columns, the first of them, returns, stamp.
const std::vector<Expected> kExpected = {
    {"OS-1-64_1024x10_fw20.pcap",
     "OS-1-64_sensor_config_reduced.json",
     {{"complete_scans", 1}, {"imu_packets", 11}, {"lidar_packets", 64}},
     {{"capture_datagrams", 75}, {"capture_records", 75}},
     {{1024, 0, 16749, 278311354710}}},
    {"OS-1-32-G_v2.1.1_1024x10.pcap",
     "OS-1-32-G_v2.1.1_1024x10.json",
     {{"complete_scans", 1}, {"lidar_packets", 64}},
     {{"capture_datagrams", 64}, {"capture_records", 64}},
     {{1024, 0, 27310, 3577233516920}}},
    {"OS-2-32-U0_v2.0.0_1024x10.pcap",
     "OS-2-32-U0_v2.0.0_1024x10.json",
     {{"complete_scans", 1}, {"lidar_packets", 64}},
     {{"capture_datagrams", 64}, {"capture_records", 64}},
     {{1024, 0, 28541, 464572961040}}},
    {"OS-0-128-U1_v2.3.0_1024x10.pcap",
     "OS-0-128-U1_v2.3.0_1024x10.json",
     {{"complete_scans", 1}, {"imu_packets", 10}, {"lidar_packets", 64}},
     {{"capture_datagrams", 74}, {"capture_records", 74}},
     {{1024, 0, 97299, 1462659326740}}},
    {"OS-1-128_v2.3.0_1024x10_lb_n3.pcap",
     "OS-1-128_v2.3.0_1024x10.json",
     {{"complete_scans", 3}, {"imu_packets", 30}, {"lidar_packets", 192}},
     {{"capture_datagrams", 222}, {"capture_records", 222}},
     {{1024, 0, 107647, 991687215910},
      {1024, 0, 107357, 991787226800},
      {1024, 0, 107532, 991887302080}}},
    {"OS-2-128-U1_v2.3.0_1024x10.pcap",
     "OS-2-128-U1_v2.3.0_1024x10.json",
     {{"complete_scans", 1}, {"imu_packets", 10}, {"lidar_packets", 64}},
     {{"capture_datagrams", 74}, {"capture_records", 74}},
     {{1024, 0, 119682, 765796889250}}},
    {"OS-0-32-U1_v2.2.0_1024x10.pcap",
     "OS-0-32-U1_v2.2.0_1024x10.json",
     {{"complete_scans", 1}, {"imu_packets", 10}, {"lidar_packets", 64}},
     {{"capture_datagrams", 74}, {"capture_records", 74}},
     {{1024, 0, 21631, 515916686600}}},
    {"OS-0-32-U1_v2.2.0_1024x10-single-packet.pcap",
     "OS-0-32-U1_v2.2.0_1024x10.json",
     {{"incomplete_scans", 1}, {"lidar_packets", 1}, {"lost_column", 1008}},
     {{"capture_datagrams", 1}, {"capture_records", 1}},
     {{16, 0, 223, 515818359360}}},
    {"OS-1-128_767798045_1024x10_20230712_120049.pcap",
     "OS-1-128_767798045_1024x10_20230712_120049.json",
     {{"imu_packets", 2}, {"incomplete_scans", 1}, {"lidar_packets", 8}, {"lost_column", 896}},
     {{"capture_datagrams", 10}, {"capture_records", 10}},
     {{128, 0, 16373, 647852396656}}},
    {"crc_test.pcap",
     "crc_test.json",
     {{"complete_scans", 1},
      {"imu_packets", 10},
      {"incomplete_scans", 1},
      {"lidar_packets", 34},
      {"lost_column", 480}},
     {{"capture_datagrams", 44}, {"capture_records", 44}},
     {{512, 0, 28055, 11890761335040}, {32, 0, 1637, 11890767570904}}},
    {"windowed_frame1.pcap",
     "windowed_frame1_0.json",
     {{"column_outside_window", 16},
      {"complete_scans", 1},
      {"imu_packets", 10},
      {"lidar_packets", 17}},
     {{"capture_datagrams", 27}, {"capture_records", 27}},
     {{256, 1, 9246, 866150332992}}},
    {"windowed_frame2.pcap",
     "windowed_frame2_0.json",
     {{"column_outside_window", 12},
      {"complete_scans", 1},
      {"imu_packets", 10},
      {"lidar_packets", 15}},
     {{"capture_datagrams", 25}, {"capture_records", 25}},
     {{228, 0, 8447, 1089341952463}}},
    {"duplicate_id.pcap",
     "duplicate_id.json",
     {{"incomplete_scans", 1}, {"lidar_packets", 1}, {"lost_column", 1008}},
     {{"capture_datagrams", 1}, {"capture_incomplete_datagram", 1}, {"capture_records", 7}},
     {{16, 432, 1779, 1697084629343806208}}},
    {"shot_limiting_test.pcap",
     "shot_limiting_test.json",
     {{"incomplete_scans", 1}, {"lidar_packets", 1}, {"lost_column", 1008}},
     {{"capture_datagrams", 1}, {"capture_records", 1}},
     {{16, 16, 2048, 1603058523272}}},
    {"same_ports.pcap",
     "same_ports.1.json",
     {{"imu_packets", 2},
      {"incomplete_scans", 1},
      {"lidar_packets", 1},
      {"lost_column", 95},
      {"wrong_size", 1}},
     {{"capture_datagrams", 4}, {"capture_records", 23}},
     {{16, 912, 1964, 8949339082728}}},
    {"same_ports.pcap",
     "same_ports.2.json",
     {{"imu_packets", 2},
      {"incomplete_scans", 1},
      {"lidar_packets", 1},
      {"lost_column", 95},
      {"wrong_size", 1}},
     {{"capture_datagrams", 4}, {"capture_records", 23}},
     {{16, 912, 985, 8915907280973}}},
    {"same_ports_legacy.pcap",
     "same_ports_legacy.1.json",
     {{"incomplete_scans", 1}, {"lidar_packets", 1}, {"lost_column", 1008}, {"wrong_size", 1}},
     {{"capture_datagrams", 2}, {"capture_records", 26}},
     {{16, 704, 486, 133790450416}}},
    {"same_ports_legacy.pcap",
     "same_ports_legacy.2.json",
     {{"incomplete_scans", 1}, {"lidar_packets", 1}, {"lost_column", 1008}, {"wrong_size", 1}},
     {{"capture_datagrams", 2}, {"capture_records", 26}},
     {{16, 96, 63, 12103085860130}}},
    {"same_ports_nonlegacy.pcap",
     "same_ports_nonlegacy.1.json",
     {{"imu_packets", 2},
      {"incomplete_scans", 1},
      {"lidar_packets", 1},
      {"lost_column", 1008},
      {"other_sensor", 1}},
     {{"capture_datagrams", 4}, {"capture_records", 26}},
     {{16, 48, 1547, 16011017568360}}},
    {"same_ports_nonlegacy.pcap",
     "same_ports_nonlegacy.2.json",
     {{"imu_packets", 2},
      {"incomplete_scans", 1},
      {"lidar_packets", 1},
      {"lost_column", 1008},
      {"wrong_type", 1}},
     {{"capture_datagrams", 4}, {"capture_records", 26}},
     {{16, 496, 872, 11087827116297}}},
    {"empty_pcap.pcap", "empty_pcap.json", {}, {}, {}},
    {"VLI-16-one-packet.pcap",
     "crc_test.json",
     {{"wrong_port", 1}},
     {{"capture_datagrams", 1}, {"capture_records", 1}},
     {}},
};

}  // namespace

TEST_CASE(
    "every capture yields exactly its columns and returns, and every datagram is accounted for") {
  for (const Expected& expected : kExpected) {
    CAPTURE(expected.pcap_file);
    CAPTURE(expected.json_file);
    const Replay result = replay(expected.pcap_file, expected.json_file);
    CHECK(result.stream == expected.stream);
    CHECK(result.capture == expected.capture);
    REQUIRE(result.scans.size() == expected.scans.size());
    for (std::size_t i = 0; i < result.scans.size(); ++i) {
      const Scan& scan = result.scans[i];
      CHECK(scan.index == i);
      CHECK(valid_columns_of(scan) == expected.scans[i].valid_columns);
      CHECK(first_valid_column_of(scan) == expected.scans[i].first_valid_column);
      CHECK(returns_of(scan) == expected.scans[i].returns);
      CHECK(scan.stamp.ns == expected.scans[i].stamp_ns);
    }
  }
}

TEST_CASE("ranges, reflectivities and stamps of whole frames have the published digests") {
  for (const std::string name :
       {"OS-0-128-U1_v2.3.0_1024x10", "OS-0-32-U1_v2.2.0_1024x10", "OS-1-32-G_v2.1.1_1024x10",
        "OS-2-128-U1_v2.3.0_1024x10", "OS-2-32-U0_v2.0.0_1024x10"}) {
    CAPTURE(name);
    std::ifstream file(kCaptures / (name + "_digest.json"));
    const nlohmann::json digests = nlohmann::json::parse(file);
    const Replay result = replay(name + ".pcap", name + ".json");
    REQUIRE(result.scans.size() == digests["scans"].size());
    for (std::size_t i = 0; i < result.scans.size(); ++i) {
      CHECK(md5_of(result.scans[i].ranges_mm) == digests["scans"][i]["RANGE"]);
      CHECK(md5_of(result.scans[i].column_stamps) == digests["scans"][i]["TIMESTAMP"]);
    }
    const PacketDigests packets = packet_digests(name + ".pcap", metadata_of(name + ".json"));
    CHECK(packets.ranges == digests["packet_hash"]["RANGE"]);
    CHECK(packets.stamps == digests["packet_hash"]["TIMESTAMP"]);
    CHECK(std::to_string(packets.frame_id) == digests["scans"].back()["FRAME_ID"]);
    CHECK(packets.measurement_ids == digests["packet_hash"]["MEASUREMENT_ID"]);
    CHECK(packets.reflectivities == digests["packet_hash"]["REFLECTIVITY"]);
  }
}

TEST_CASE("an azimuth window over column 0 leaves the columns outside it invalid") {
  const Replay result = replay("windowed_frame2.pcap", "windowed_frame2_0.json");
  REQUIRE(result.scans.size() == 1);
  for (int column = 0; column < 512; ++column) {
    CHECK((result.scans[0].column_valid[column] == 1) == (column <= 85 || column >= 370));
  }
}

TEST_CASE("packets set up anew since the metadata was written are counted and dropped") {
  SensorMetadata metadata = metadata_of("crc_test.json");
  metadata.init_id += 1;
  const Replay result = replay("crc_test.pcap", metadata);
  CHECK(result.scans.empty());
  CHECK(result.stream == Counts{{"imu_packets", 10}, {"wrong_init_id", 34}});
}

TEST_CASE("where the metadata does not name the sensor, the first one on the port is followed") {
  SensorMetadata metadata = metadata_of("same_ports_nonlegacy.2.json");
  metadata.serial_number = 0;
  metadata.init_id = 0;
  const Replay result = replay("same_ports_nonlegacy.pcap", metadata);
  REQUIRE(result.scans.size() == 1);
  CHECK(returns_of(result.scans[0]) == 872);
}

TEST_CASE("a capture of zero bytes is refused, one with a header alone has no packets") {
  const Result<PcapSource> empty = PcapSource::open(kCaptures / "OS-0-128_v3.0.1_1024x10.pcap");
  REQUIRE_FALSE(empty.has_value());
  CHECK(empty.error().kind == ErrorKind::kInput);
  CHECK(empty.error().message.find("OS-0-128_v3.0.1_1024x10.pcap: is empty") != std::string::npos);

  Result<PcapSource> header_only = PcapSource::open(kCaptures / "empty_pcap.pcap");
  REQUIRE(header_only.has_value());
  UdpDatagram datagram;
  CHECK(header_only->next(datagram) == false);
  CHECK_FALSE(header_only->warning().has_value());
}

TEST_CASE("a capture without lidar packets yields its other datagrams, its profile is refused") {
  Result<PcapSource> source = PcapSource::open(kCaptures / "imu_zm_no_lidar.pcap");
  REQUIRE(source.has_value());
  std::map<int, int> datagrams_by_port;
  UdpDatagram datagram;
  while (source->next(datagram) == true) ++datagrams_by_port[datagram.destination_port];
  CHECK(datagrams_by_port == std::map<int, int>{{7513, 8}, {7514, 1}});

  const Result<SensorMetadata> metadata = load_metadata(kCaptures / "imu_zm_no_lidar_0.json");
  REQUIRE_FALSE(metadata.has_value());
  CHECK(metadata.error().message.find("RNG19_RFL8_SIG16_NIR16_ZONE16") != std::string::npos);
}

TEST_CASE("a capture cut off at any byte of its last packet ends there with a warning") {
  const Result<std::string> whole = read_file(kCaptures / "crc_test.pcap");
  REQUIRE(whole.has_value());
  const auto bytes = std::as_bytes(std::span(*whole));
  for (const std::size_t missing : {1, 100, 8489, 8490, 8491, 8505}) {
    CAPTURE(missing);
    Result<PcapSource> source = PcapSource::from_memory(bytes.first(bytes.size() - missing), "cut");
    REQUIRE(source.has_value());
    UdpDatagram datagram;
    int num_datagrams = 0;
    while (source->next(datagram) == true) ++num_datagrams;
    CHECK(num_datagrams == 43);
    REQUIRE(source->warning().has_value());
    CHECK(source->warning()->starts_with("cut: cut off inside its last packet, at byte"));
  }
}
