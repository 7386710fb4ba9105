#include "firmware_interface/ros2/cloud_layout.hpp"

#include <bit>

#include "firmware_interface/ros2/message_parts.hpp"

namespace cloister::ros2 {

std::uint8_t* make_cloud(PointCloud2& cloud, std::span<const CloudField> fields,
                         std::uint32_t point_bytes, std::uint32_t height, std::uint32_t width) {
  PointField* field = make_elements(cloud.fields, fields.size());
  for (const CloudField& described : fields) {
    set_text(field->name, described.name);
    field->offset = described.offset;
    field->datatype = described.datatype;
    field->count = 1;
    ++field;
  }
  cloud.height = height;
  cloud.width = width;
  cloud.is_bigendian = std::endian::native == std::endian::big;
  cloud.point_step = point_bytes;
  cloud.row_step = point_bytes * width;
  return make_elements(cloud.data, std::size_t{cloud.row_step} * height);
}

}  // namespace cloister::ros2
