#include "bench/simulate/legacy_packet.hpp"

namespace cloister {

namespace {

constexpr std::uint32_t kColumnValid = 0xFFFFFFFF;
constexpr std::uint32_t kRangeMask = 0xFFFFF;

template <typename Integer>
void put(Integer value, std::vector<std::uint8_t>* out) {
  for (std::size_t byte = 0; byte < sizeof(Integer); ++byte) {
    out->push_back(static_cast<std::uint8_t>(value >> (8 * byte)));
  }
}

}  // namespace

void append_legacy_packet(std::span<const ColumnReturns> columns, std::vector<std::uint8_t>* out) {
  for (const ColumnReturns& column : columns) {
    put(column.stamp_ns, out);
    put(column.measurement_id, out);
    put(column.frame_id, out);
    put(column.encoder_ticks, out);
    for (const PixelReturn& pixel : column.pixels) {
      put(pixel.range_mm & kRangeMask, out);
      put(pixel.reflectivity, out);
      put(pixel.signal, out);
      put(pixel.near_ir, out);
      put(std::uint16_t{0}, out);
    }
    put(kColumnValid, out);
  }
}

}  // namespace cloister
