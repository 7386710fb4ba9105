// Any bytes as a stream of lidar packets. The first byte chooses profile and beam count, the next
// two the azimuth window; the rest becomes packets: whole ones as they lie, and short ones that
// overwrite the start of the one before, so that a small input reaches headers and columns of
// full-sized packets.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "firmware_interface/ouster/scan_assembler.hpp"

namespace {

using namespace cloister;

SensorMetadata sensor(std::uint8_t choice, std::uint8_t first, std::uint8_t last) {
  constexpr std::array<int, 4> kBeams = {16, 32, 64, 128};
  SensorMetadata metadata;
  metadata.num_columns = 512;
  metadata.rate_hz = 10;
  metadata.num_beams = kBeams[(choice >> 4) % kBeams.size()];
  metadata.column_window = {2 * first, 2 * last};
  metadata.profile = kPacketLayouts[choice % kPacketLayouts.size()].profile;
  metadata.columns_per_packet = 16;
  return metadata;
}

void check(ScanAssembler& assembler) {
  static Scan scan;
  const auto num_columns = static_cast<std::size_t>(assembler.num_columns());
  while (assembler.take(scan)) {
    if (scan.column_valid.size() != num_columns || scan.column_stamps.size() != num_columns ||
        scan.ranges_mm.size() != num_columns * static_cast<std::size_t>(assembler.num_beams()) ||
        std::find(scan.column_valid.begin(), scan.column_valid.end(), 1) ==
            scan.column_valid.end()) {
      std::abort();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 4) return 0;
  const SensorMetadata metadata = sensor(data[0], data[1], data[2]);
  std::span<const std::byte> rest = std::as_bytes(std::span(data + 3, size - 3));
  ScanAssembler assembler(metadata);
  const auto packet_bytes = static_cast<std::size_t>(
      packet_layout(metadata.profile).packet_bytes(metadata.num_beams, 16));
  std::vector<std::byte> packet(packet_bytes);
  UdpDatagram datagram;
  datagram.destination_port = metadata.lidar_port;
  while (!rest.empty()) {
    const bool is_patch = std::to_integer<int>(rest[0]) % 2 == 0;
    const std::size_t length = std::min(is_patch ? std::size_t{64} : packet_bytes, rest.size());
    std::memcpy(packet.data(), rest.data(), length);
    rest = rest.subspan(length);
    datagram.payload = packet;
    if (assembler.push(datagram)) check(assembler);
    datagram.payload = std::span(packet).first(length);  // most often of the wrong size
    if (assembler.push(datagram)) check(assembler);
  }
  if (assembler.flush()) check(assembler);
  return 0;
}
