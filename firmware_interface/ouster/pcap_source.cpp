#include "firmware_interface/ouster/pcap_source.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <pcap/pcap.h>

namespace cloister {
namespace {

constexpr std::uint16_t kEtherTypeIpv4 = 0x0800;
constexpr std::uint16_t kEtherTypeIpv6 = 0x86dd;
constexpr std::size_t kIpv4HeaderBytes = 20;
constexpr std::size_t kUdpHeaderBytes = 8;
constexpr int kProtocolUdp = 17;

std::uint16_t load_u16(std::span<const std::byte> bytes, std::size_t offset) {
  return static_cast<std::uint16_t>((std::to_integer<unsigned>(bytes[offset]) << 8) |
                                    std::to_integer<unsigned>(bytes[offset + 1]));
}

std::uint32_t load_u32(std::span<const std::byte> bytes, std::size_t offset) {
  return (static_cast<std::uint32_t>(load_u16(bytes, offset)) << 16) | load_u16(bytes, offset + 2);
}

// A link type's header: its length, and where its ethertype lies.
// Without one, the IP version tells.
struct LinkHeader {
  int type;
  std::size_t header_bytes;
  std::optional<std::size_t> ethertype_at;
};

constexpr std::array<LinkHeader, 7> kLinkHeaders = {{{DLT_EN10MB, 14, 12},
                                                     {DLT_LINUX_SLL, 16, 14},
                                                     {DLT_LINUX_SLL2, 20, 0},
                                                     {DLT_NULL, 4, std::nullopt},
                                                     {DLT_LOOP, 4, std::nullopt},
                                                     {DLT_RAW, 0, std::nullopt},
                                                     {DLT_IPV4, 0, std::nullopt}}};

const LinkHeader* find_link_header(int type) {
  const auto found = std::find_if(kLinkHeaders.begin(), kLinkHeaders.end(),
                                  [type](const LinkHeader& link) { return link.type == type; });
  return found == kLinkHeaders.end() ? nullptr : &*found;
}

bool is_vlan_tag(std::uint16_t ethertype) {
  return ethertype == 0x8100 || ethertype == 0x88a8 || ethertype == 0x9100;
}

// Capture files can state any time; what nanoseconds cannot hold is pinned to the range they can.
std::int64_t to_nanoseconds(const timeval& time) {
  const std::int64_t seconds = std::clamp<std::int64_t>(time.tv_sec, 0, 9'000'000'000);
  return seconds * 1'000'000'000 + std::clamp<std::int64_t>(time.tv_usec, 0, 999'999'999);
}

tl::unexpected<Error> cannot_read(const std::string& name, int error) {
  return fail(ErrorKind::kInput, name +
                                     ": cannot be read: " + std::generic_category().message(error) +
                                     "; check the path and its permissions");
}

tl::unexpected<Error> is_empty(const std::string& name) {
  return fail(ErrorKind::kInput, name +
                                     ": is empty (0 bytes), a capture has at least a header; "
                                     "record it again");
}

}  // namespace

void PcapSource::Closer::operator()(pcap* handle) const { pcap_close(handle); }

PcapSource::PcapSource(std::unique_ptr<pcap, Closer> handle, int link_type, std::string name)
    : handle_(std::move(handle)),
      link_type_(link_type),
      name_(std::move(name)),
      reassembler_(std::make_unique<Ipv4Reassembler>()) {}

Result<PcapSource> PcapSource::open(const std::filesystem::path& path) {
  std::FILE* file = std::fopen(path.c_str(), "rbe");
  if (file == nullptr) return cannot_read(path.string(), errno);
  const int first = std::fgetc(file);
  if (first == EOF) {
    const int error = std::ferror(file) != 0 ? errno : 0;
    std::fclose(file);
    if (error != 0) return cannot_read(path.string(), error);
    return is_empty(path.string());
  }
  std::ungetc(first, file);
  return from_file(file, path.string());
}

Result<PcapSource> PcapSource::from_memory(std::span<const std::byte> bytes, std::string name) {
  if (bytes.empty()) return is_empty(name);
  // Opened for reading, the stream does not touch the buffer that the signature calls writable.
  std::FILE* file = fmemopen(const_cast<std::byte*>(bytes.data()), bytes.size(), "rb");
  if (file == nullptr) return cannot_read(name, errno);
  return from_file(file, std::move(name));
}

Result<PcapSource> PcapSource::from_file(std::FILE* file, std::string name) {
  std::array<char, PCAP_ERRBUF_SIZE> message{};
  std::unique_ptr<pcap, Closer> handle(
      pcap_fopen_offline_with_tstamp_precision(file, PCAP_TSTAMP_PRECISION_NANO, message.data()));
  if (handle == nullptr) {
    std::fclose(file);
    return fail(ErrorKind::kInput, name + ": not a packet capture (pcap or pcapng): " +
                                       message.data() + "; record it with tcpdump");
  }
  const int link_type = pcap_datalink(handle.get());
  if (find_link_header(link_type) == nullptr) {
    const char* known = pcap_datalink_val_to_name(link_type);
    return fail(ErrorKind::kInput,
                name + ": link type " + std::to_string(link_type) + " (" +
                    (known == nullptr ? "unknown" : known) +
                    ") is not supported; record on an Ethernet, loopback or 'any' interface");
  }
  return PcapSource(std::move(handle), link_type, std::move(name));
}

Result<bool> PcapSource::next(UdpDatagram& datagram) {
  while (!ended_) {
    pcap_pkthdr* header = nullptr;
    const u_char* data = nullptr;
    const int status = pcap_next_ex(handle_.get(), &header, &data);
    if (status == 1) {
      counters_.add(CaptureCause::kRecords);
      const std::span<const std::byte> record(reinterpret_cast<const std::byte*>(data),
                                              header->caplen);
      if (parse_record(record, to_nanoseconds(header->ts), datagram)) {
        counters_.add(CaptureCause::kDatagrams);
        return true;
      }
      continue;
    }
    finish();
    if (status == PCAP_ERROR_BREAK) return false;
    std::FILE* file = pcap_file(handle_.get());
    const std::int64_t byte = std::ftell(file);
    if (std::feof(file) != 0) {
      cut_at_byte_ = byte;
      return false;
    }
    return fail(ErrorKind::kInput, name_ + ": corrupt before byte " + std::to_string(byte) + ": " +
                                       pcap_geterr(handle_.get()) + "; record it again");
  }
  return false;
}

void PcapSource::finish() {
  ended_ = true;
  reassembler_->clear();
  counters_.add(CaptureCause::kMalformedFragment, reassembler_->malformed_fragments());
  counters_.add(CaptureCause::kRepeatedFragment, reassembler_->repeated_fragments());
  counters_.add(CaptureCause::kIncompleteDatagram, reassembler_->incomplete_datagrams());
}

std::optional<std::string> PcapSource::warning() const {
  if (!cut_at_byte_) return std::nullopt;
  return name_ + ": cut off inside its last packet, at byte " + std::to_string(*cut_at_byte_) +
         "; all packets before it were read";
}

bool PcapSource::parse_record(std::span<const std::byte> record, std::int64_t capture_time_ns,
                              UdpDatagram& datagram) {
  const LinkHeader& link = *find_link_header(link_type_);
  std::size_t ip_at = link.header_bytes;
  if (record.size() < ip_at + 1) {
    counters_.add(CaptureCause::kNotIp);
    return false;
  }
  int version = std::to_integer<int>(record[ip_at]) >> 4;
  if (link.ethertype_at) {
    std::uint16_t ethertype = load_u16(record, *link.ethertype_at);
    while (is_vlan_tag(ethertype) && record.size() >= ip_at + 4) {
      ethertype = load_u16(record, ip_at + 2);
      ip_at += 4;
    }
    version = ethertype == kEtherTypeIpv4 ? 4 : ethertype == kEtherTypeIpv6 ? 6 : 0;
  }
  if (version == 4) return parse_ipv4(record.subspan(ip_at), capture_time_ns, datagram);
  counters_.add(version == 6 ? CaptureCause::kIpv6 : CaptureCause::kNotIp);
  return false;
}

bool PcapSource::parse_ipv4(std::span<const std::byte> packet, std::int64_t capture_time_ns,
                            UdpDatagram& datagram) {
  if (packet.size() < kIpv4HeaderBytes || std::to_integer<int>(packet[0]) >> 4 != 4) {
    counters_.add(CaptureCause::kMalformedHeader);
    return false;
  }
  const std::size_t header_bytes = 4 * (std::to_integer<std::size_t>(packet[0]) & 0xf);
  std::size_t total_bytes = load_u16(packet, 2);
  // A network card that cuts large packets itself fills in their lengths: 0 in the capture.
  if (total_bytes == 0) total_bytes = packet.size();
  if (header_bytes < kIpv4HeaderBytes || total_bytes < header_bytes) {
    counters_.add(CaptureCause::kMalformedHeader);
    return false;
  }
  if (total_bytes > packet.size()) {
    counters_.add(CaptureCause::kCutRecord);
    return false;
  }
  if (std::to_integer<int>(packet[9]) != kProtocolUdp) {
    counters_.add(CaptureCause::kNotUdp);
    return false;
  }

  const std::uint16_t flags = load_u16(packet, 6);
  Ipv4Fragment fragment;
  fragment.source_address = load_u32(packet, 12);
  fragment.destination_address = load_u32(packet, 16);
  fragment.id = load_u16(packet, 4);
  fragment.offset = 8 * (flags & 0x1fff);
  fragment.more = (flags & 0x2000) != 0;
  fragment.capture_time_ns = capture_time_ns;
  fragment.payload = packet.subspan(header_bytes, total_bytes - header_bytes);

  datagram.source_address = fragment.source_address;
  datagram.capture_time_ns = capture_time_ns;
  if (fragment.offset == 0 && !fragment.more) return parse_udp(fragment.payload, datagram);
  const std::span<const std::byte> whole = reassembler_->add(fragment);
  return !whole.empty() && parse_udp(whole, datagram);
}

bool PcapSource::parse_udp(std::span<const std::byte> segment, UdpDatagram& datagram) {
  const std::size_t length = segment.size() < kUdpHeaderBytes ? 0 : load_u16(segment, 4);
  if (length < kUdpHeaderBytes || length > segment.size()) {
    counters_.add(CaptureCause::kMalformedHeader);
    return false;
  }
  datagram.source_port = load_u16(segment, 0);
  datagram.destination_port = load_u16(segment, 2);
  datagram.payload = segment.subspan(kUdpHeaderBytes, length - kUdpHeaderBytes);
  return true;
}

}  // namespace cloister
