#include "firmware_interface/ouster/packet_decoder.hpp"

#include <cstring>

namespace cloister {
namespace {

constexpr std::uint64_t kLidarPacketType = 1;

// 146 years after either epoch: a stamp past it is garbage,
// and below it differences of stamps cannot overflow.
constexpr std::uint64_t kMaxStampNs = 1ULL << 62;

// Beams outside, columns inside: a packet's columns are neighbours in the scan,
// so that each row is written as a run.
template <typename Word>
void copy_words(const std::byte* first_pixel, int column_bytes, int pixel_bytes, int num_beams,
                const PacketField& field, std::span<const int> packet_columns,
                std::span<const int> scan_columns, int num_scan_columns, std::uint32_t* ranges_mm) {
  const auto mask = static_cast<std::uint32_t>(field.mask);
  for (int beam = 0; beam < num_beams; ++beam) {
    const std::byte* pixels = first_pixel + beam * pixel_bytes + field.offset;
    std::uint32_t* row = ranges_mm + static_cast<std::ptrdiff_t>(beam) * num_scan_columns;
    for (std::size_t i = 0; i < packet_columns.size(); ++i) {
      Word word;
      std::memcpy(&word, pixels + packet_columns[i] * column_bytes, sizeof(Word));
      row[scan_columns[i]] = (word & mask) << field.shift;
    }
  }
}

}  // namespace

PacketDecoder::PacketDecoder(UdpProfile profile, int num_beams, int columns_per_packet)
    : layout_(packet_layout(profile)),
      num_beams_(num_beams),
      columns_per_packet_(columns_per_packet),
      column_bytes_(layout_.column_bytes(num_beams)),
      packet_bytes_(static_cast<std::size_t>(layout_.packet_bytes(num_beams, columns_per_packet))) {
}

PacketHeader PacketDecoder::header(std::span<const std::byte> packet) const {
  const std::byte* start = packet.data();
  PacketHeader header;
  header.frame_id = static_cast<std::uint32_t>(layout_.frame_id.load(start));
  header.init_id = static_cast<std::uint32_t>(layout_.init_id.load(start));
  header.serial_number = layout_.serial_number.load(start);
  header.is_lidar =
      !layout_.packet_type.present() || layout_.packet_type.load(start) == kLidarPacketType;
  return header;
}

ColumnHeader PacketDecoder::column(std::span<const std::byte> packet, int column_idx) const {
  const std::byte* start = column_start(packet, column_idx);
  const std::uint64_t stamp_ns = layout_.timestamp_ns.load(start);
  const std::uint64_t status = layout_.status.load(start + layout_.status_base(num_beams_));
  const bool same_frame =
      !layout_.column_frame_id.present() ||
      layout_.column_frame_id.load(start) == layout_.frame_id.load(packet.data());
  ColumnHeader header;
  header.measurement_id = static_cast<int>(layout_.measurement_id.load(start));
  header.valid = status == layout_.status.mask && stamp_ns < kMaxStampNs && same_frame;
  header.stamp.ns = static_cast<std::int64_t>(header.valid ? stamp_ns : 0);
  return header;
}

void PacketDecoder::copy_ranges(std::span<const std::byte> packet,
                                std::span<const int> packet_columns,
                                std::span<const int> scan_columns, int num_scan_columns,
                                std::span<std::uint32_t> ranges_mm) const {
  const std::byte* first_pixel = column_start(packet, 0) + layout_.column_header_bytes;
  const auto copy =
      layout_.range_mm.bytes == 2 ? copy_words<std::uint16_t> : copy_words<std::uint32_t>;
  copy(first_pixel, column_bytes_, layout_.pixel_bytes, num_beams_, layout_.range_mm,
       packet_columns, scan_columns, num_scan_columns, ranges_mm.data());
}

}  // namespace cloister
