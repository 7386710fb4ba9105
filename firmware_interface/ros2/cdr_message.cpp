#include "firmware_interface/ros2/cdr_message.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/q_protocol.h>

namespace cloister::ros2 {
namespace {

constexpr std::size_t kHeaderBytes = 4;
// The second byte of the header; the first one is zero.
constexpr std::byte kBigEndian{0};
constexpr std::byte kLittleEndian{1};

}  // namespace

bool decode_cdr(std::span<const std::byte> cdr, const dds_topic_descriptor_t& type,
                std::vector<std::byte>& scratch, void* sample, MessageCounters& counters) {
  counters.add(MessageCause::kMessages);
  if (cdr.size() < kHeaderBytes || cdr[0] != std::byte{0} ||
      (cdr[1] != kBigEndian && cdr[1] != kLittleEndian)) {
    counters.add(MessageCause::kUnknownEncapsulation);
    return false;
  }
  const std::byte native = std::endian::native == std::endian::little ? kLittleEndian : kBigEndian;
  const std::span<const std::byte> body = cdr.subspan(kHeaderBytes);
  // Offsets in CDR count from behind the header, which is where the copy is aligned.
  scratch.assign(body.begin(), body.end());
  std::uint32_t used = 0;
  if (body.empty() || body.size() > std::numeric_limits<std::int32_t>::max() ||
      dds_stream_normalize_data(reinterpret_cast<char*>(scratch.data()), &used,
                                static_cast<std::uint32_t>(body.size()), cdr[1] != native,
                                CDR_ENC_VERSION_1, type.m_ops) == nullptr) {
    counters.add(MessageCause::kMalformedMessage);
    return false;
  }
  dds_istream_t stream;
  dds_istream_init(&stream, used, scratch.data(), CDR_ENC_VERSION_1);
  static_cast<void>(dds_stream_read(&stream, static_cast<char*>(sample), type.m_ops));
  return true;
}

std::vector<std::byte> encode_cdr(const dds_topic_descriptor_t& type, const void* sample) {
  dds_ostreamLE_t stream;
  dds_ostreamLE_init(&stream, 4096, CDR_ENC_VERSION_1);
  static_cast<void>(dds_stream_writeLE(&stream, static_cast<const char*>(sample), type.m_ops));
  std::vector<std::byte> cdr(kHeaderBytes + stream.x.m_index);
  cdr[1] = kLittleEndian;
  std::memcpy(cdr.data() + kHeaderBytes, stream.x.m_buffer, stream.x.m_index);
  dds_ostreamLE_fini(&stream);
  return cdr;
}

void free_contents(const dds_topic_descriptor_t& type, void* sample) {
  dds_stream_free_sample(sample, type.m_ops);
}

}  // namespace cloister::ros2
