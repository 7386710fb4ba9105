// Any bytes as a sensor's metadata: refused with one line, or parsed into what has a geometry.

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "firmware_interface/ouster/ouster_geometry.hpp"
#include "firmware_interface/ouster/sensor_metadata.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const cloister::Result<cloister::SensorMetadata> metadata =
      cloister::parse_metadata(text, "metadata.json");
  if (!metadata) {
    if (metadata.error().message.find('\n') != std::string::npos) std::abort();
    return 0;
  }
  const cloister::ScanGeometry geometry = cloister::make_geometry(*metadata);
  const auto num_pixels = static_cast<std::size_t>(geometry.num_beams * geometry.num_columns);
  if (geometry.direction_L.size() != num_pixels || geometry.origin_L.size() != num_pixels ||
      geometry.pixel_shift.size() != static_cast<std::size_t>(geometry.num_beams)) {
    std::abort();
  }
  return 0;
}
