#include "firmware_interface/ouster/pcap_source.hpp"

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "test/support/capture_builder.hpp"

using namespace cloister;
using namespace cloister::testing;

namespace {

const Bytes kPayload = {std::byte{1}, std::byte{2}, std::byte{3}};

struct Read {
  std::vector<Bytes> payloads;
  UdpDatagram last;  // its payload is gone
  Counters<CaptureCause> counters;
  std::optional<Error> error;
};

Read read(const Bytes& capture) {
  Result<PcapSource> source = PcapSource::from_memory(capture, "memory");
  REQUIRE_MESSAGE(source.has_value(), source.error().message);
  Read result;
  while (true) {
    const Result<bool> more = source->next(result.last);
    if (!more) result.error = more.error();
    if (!more || !*more) break;
    result.payloads.emplace_back(result.last.payload.begin(), result.last.payload.end());
  }
  result.counters = source->counters();
  return result;
}

Read read_one(const Bytes& record, std::uint32_t link_type = 1, int missing_bytes = 0) {
  PcapBuilder capture(link_type);
  capture.add(record, 0, missing_bytes);
  return read(capture.bytes());
}

// The same record in a pcapng file: section header, interface description, enhanced packet.
Bytes pcapng(const Bytes& record, int link_type = 1) {
  Bytes out;
  put_le(out, 0x0a0d0d0a, 4);
  put_le(out, 28, 4);
  put_le(out, 0x1a2b3c4d, 4);
  put_le(out, 1, 2);
  put_le(out, 0, 2);
  put_le(out, ~0ULL, 8);
  put_le(out, 28, 4);
  put_le(out, 1, 4);
  put_le(out, 20, 4);
  put_le(out, static_cast<std::uint64_t>(link_type), 2);
  put_le(out, 0, 2);
  put_le(out, 0, 4);
  put_le(out, 20, 4);
  const std::size_t padded = (record.size() + 3) / 4 * 4;
  put_le(out, 6, 4);
  put_le(out, 32 + padded, 4);
  put_le(out, 0, 4);
  const std::uint64_t time_us = 1'700'000'000'123'456;
  put_le(out, time_us >> 32, 4);
  put_le(out, time_us & 0xffffffff, 4);
  put_le(out, record.size(), 4);
  put_le(out, record.size(), 4);
  put(out, record);
  out.resize(out.size() + padded - record.size());
  put_le(out, 32 + padded, 4);
  return out;
}

}  // namespace

TEST_CASE("a datagram is found behind every link layer") {
  const Bytes packet = ipv4_packet(udp_segment(kPayload));
  const std::vector<Bytes> one = {kPayload};
  CHECK(read_one(ethernet(packet)).payloads == one);
  CHECK(read_one(ethernet(packet, 0x0800, {0x8100})).payloads == one);
  CHECK(read_one(ethernet(packet, 0x0800, {0x88a8, 0x8100})).payloads == one);
  CHECK(read_one(linux_cooked(packet), 113).payloads == one);
  CHECK(read_one(linux_cooked_2(packet), 276).payloads == one);
  CHECK(read_one(loopback(packet), 0).payloads == one);
  CHECK(read_one(loopback(packet, 0x02000000), 0).payloads == one);
  CHECK(read_one(loopback(packet), 108).payloads == one);
  CHECK(read_one(packet, 101).payloads == one);
  CHECK(read_one(packet, 228).payloads == one);
}

TEST_CASE("a datagram carries its addresses, its port and when it was captured") {
  PcapBuilder capture;
  capture.add(ethernet(ipv4_packet(udp_segment(kPayload, 7777), {.source = 0x0a050665})),
              1'500'000);
  const Read result = read(capture.bytes());
  CHECK(result.payloads.size() == 1);
  CHECK(result.last.source_address == 0x0a050665);
  CHECK(result.last.source_port == 50000);
  CHECK(result.last.destination_port == 7777);
  CHECK(result.last.capture_time_ns == 1'500'000'000);
}

TEST_CASE("pcapng is read like pcap") {
  const Read result = read(pcapng(ethernet(ipv4_packet(udp_segment(kPayload)))));
  CHECK(result.payloads == std::vector<Bytes>{kPayload});
  CHECK(result.last.capture_time_ns == 1'700'000'000'123'456'000);
}

TEST_CASE("bytes behind the IP packet, as short Ethernet frames are filled up, do not count") {
  Bytes record = ethernet(ipv4_packet(udp_segment(kPayload)));
  record.resize(60);
  CHECK(read_one(record).payloads == std::vector<Bytes>{kPayload});
}

TEST_CASE("a packet whose length was left to the network card is taken as long as it is") {
  const Bytes packet = ipv4_packet(udp_segment(kPayload), {.total_length = 0});
  CHECK(read_one(ethernet(packet)).payloads == std::vector<Bytes>{kPayload});
}

TEST_CASE("fragments are put together, the datagram around them is cut to its UDP length") {
  Bytes payload(12608);
  for (std::size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<std::byte>(i * 7);
  PcapBuilder capture;
  for (int i = 0; i < 100; ++i) capture.add_fragmented(udp_segment(payload), i, 1000 * i);
  const Read result = read(capture.bytes());
  CHECK(result.payloads == std::vector<Bytes>(100, payload));
  CHECK(result.counters[CaptureCause::kRecords] == 900);
  CHECK(result.counters[CaptureCause::kIncompleteDatagram] == 0);
}

TEST_CASE("what is not UDP over IPv4 is skipped under its cause") {
  const Bytes packet = ipv4_packet(udp_segment(kPayload));
  const auto counts = [](const Read& result, CaptureCause cause) {
    return result.payloads.empty() && !result.error && result.counters[cause] == 1;
  };
  CHECK(counts(read_one(ethernet(Bytes(60), 0x86dd)), CaptureCause::kIpv6));
  CHECK(counts(read_one(loopback(Bytes(60, std::byte{0x60}), 30), 0), CaptureCause::kIpv6));
  CHECK(counts(read_one(ethernet(Bytes(60), 0x0806)), CaptureCause::kNotIp));
  CHECK(counts(read_one(Bytes(5)), CaptureCause::kNotIp));
  CHECK(counts(read_one(ethernet(Bytes(2), 0x8100)), CaptureCause::kNotIp));
  CHECK(counts(read_one(ethernet(ipv4_packet(kPayload, {.protocol = 6}))), CaptureCause::kNotUdp));
}

TEST_CASE("headers that contradict themselves are counted and dropped") {
  const Bytes segment = udp_segment(kPayload);
  const auto is_malformed = [](const Bytes& packet) {
    const Read result = read_one(ethernet(packet));
    return result.payloads.empty() && result.counters[CaptureCause::kMalformedHeader] == 1;
  };
  CHECK(is_malformed(Bytes(19, std::byte{0x45})));
  CHECK(is_malformed(ipv4_packet(segment, {.header_words = 4})));
  CHECK(is_malformed(ipv4_packet(segment, {.total_length = 19})));
  CHECK(is_malformed(ipv4_packet(Bytes(7))));
  Bytes too_long = segment;
  too_long[5] = std::byte{200};
  CHECK(is_malformed(ipv4_packet(too_long)));
  Bytes too_short = segment;
  too_short[5] = std::byte{7};
  CHECK(is_malformed(ipv4_packet(too_short)));
}

TEST_CASE("a record that the capture cut short is counted and dropped") {
  Bytes record = ethernet(ipv4_packet(udp_segment(kPayload)));
  record.resize(record.size() - 2);
  const Read result = read_one(record, 1, 2);
  CHECK(result.payloads.empty());
  CHECK(result.counters[CaptureCause::kCutRecord] == 1);
}

TEST_CASE("a file that cannot be a capture is refused with its name") {
  const auto message_of = [](const std::filesystem::path& path) {
    const Result<PcapSource> source = PcapSource::open(path);
    REQUIRE_FALSE(source.has_value());
    CHECK(source.error().kind == ErrorKind::kInput);
    CHECK(source.error().message.find('\n') == std::string::npos);
    return source.error().message;
  };
  const std::filesystem::path data = std::filesystem::path(CLOISTER_TEST_DATA) / "ouster_captures";
  CHECK(message_of("/no/such/lidar.pcap").find("No such file") != std::string::npos);
  CHECK(message_of(data).find("directory") != std::string::npos);
  CHECK(message_of(data / "LICENSE").find("LICENSE: not a packet capture") != std::string::npos);
  CHECK_FALSE(PcapSource::from_memory(Bytes(10), "short").has_value());
  CHECK_FALSE(PcapSource::from_memory({}, "nothing").has_value());

  const Result<PcapSource> other = PcapSource::from_memory(PcapBuilder(105).bytes(), "wifi.pcap");
  REQUIRE_FALSE(other.has_value());
  CHECK(other.error().message.starts_with("wifi.pcap: link type 105"));
}

TEST_CASE("a file that is corrupt between packets is an error that names the byte") {
  PcapBuilder capture;
  const Bytes record = ethernet(ipv4_packet(udp_segment(kPayload)));
  capture.add(record);
  Bytes bytes = capture.bytes();
  put_le(bytes, ~0ULL, 8);  // a record header without sense
  put_le(bytes, ~0ULL, 8);
  put(bytes, record);
  const Read result = read(bytes);
  CHECK(result.payloads.size() == 1);
  REQUIRE(result.error.has_value());
  CHECK(result.error->kind == ErrorKind::kInput);
  CHECK(result.error->message.starts_with("memory: corrupt before byte "));
}

TEST_CASE("garbage in captured packets is survived") {
  std::mt19937 random(20240611);
  for (int round = 0; round < 200; ++round) {
    CAPTURE(round);
    PcapBuilder capture;
    Bytes record = ethernet(ipv4_packet(udp_segment(Bytes(64)), {.more = round % 2 == 0}));
    for (int flips = 0; flips < 8; ++flips) {
      record[12 + random() % (record.size() - 12)] = static_cast<std::byte>(random());
    }
    for (int repeat = 0; repeat < 4; ++repeat) capture.add(record);
    CHECK_FALSE(read(capture.bytes()).error.has_value());
  }
}
