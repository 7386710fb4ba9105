#include "firmware_interface/ouster/udp_source.hpp"

#include <poll.h>

#include <doctest/doctest.h>

namespace cloister {
namespace {

UdpSource open_source(int receive_buffer_bytes = 16 << 20) {
  auto source = UdpSource::open(
      {.port = 0, .address = "127.0.0.1", .receive_buffer_bytes = receive_buffer_bytes});
  REQUIRE(source.has_value());
  return std::move(*source);
}

UdpSender open_sender(const UdpSource& source) {
  auto sender = UdpSender::open("127.0.0.1", source.port());
  REQUIRE(sender.has_value());
  return std::move(*sender);
}

/// Loopback hands a datagram over before send returns, so what is readable is all there is.
bool is_readable(const UdpSource& source) {
  pollfd waited{source.file_descriptor(), POLLIN, 0};
  return poll(&waited, 1, 0) == 1;
}

TEST_CASE("datagrams of every size arrive whole and in order with their sender" *
          doctest::test_suite("host_kernel")) {
  UdpSource source = open_source();
  UdpSender sender = open_sender(source);
  UdpDatagram datagram;
  CHECK_FALSE(source.next(datagram));
  // More than one batch, up to the longest lidar packet there is.
  for (std::size_t i = 0; i < 100; ++i) {
    REQUIRE(sender.send(std::vector<std::byte>(i * 331, static_cast<std::byte>(i))));
  }
  CHECK(is_readable(source));
  for (std::size_t i = 0; i < 100; ++i) {
    REQUIRE(source.next(datagram));
    CHECK(datagram.payload.size() == i * 331);
    if (i > 0) CHECK(datagram.payload.back() == static_cast<std::byte>(i));
    CHECK(datagram.source_address == 0x7f000001);
    CHECK(datagram.destination_port == source.port());
    CHECK(datagram.capture_time_ns > 1'600'000'000'000'000'000);
  }
  CHECK_FALSE(source.next(datagram));
  CHECK_FALSE(is_readable(source));
  CHECK(source.counters()[SocketCause::kDatagrams] == 100);
  CHECK(source.counters()[SocketCause::kKernelDrops] == 0);
}

TEST_CASE("what does not fit into the receive buffer is counted by the datagram" *
          doctest::test_suite("host_kernel")) {
  UdpSource source = open_source(/*receive_buffer_bytes=*/200'000);
  UdpSender sender = open_sender(source);
  constexpr std::uint64_t kSent = 500;
  const std::vector<std::byte> payload(12'608);
  for (std::uint64_t i = 0; i < kSent; ++i) (void)sender.send(payload);
  UdpDatagram datagram;
  while (source.next(datagram)) {
  }
  // The count travels with the datagrams that arrive later.
  REQUIRE(sender.send(payload));
  REQUIRE(source.next(datagram));
  CHECK(source.counters()[SocketCause::kKernelDrops] > 0);
  CHECK(source.counters()[SocketCause::kDatagrams] + source.counters()[SocketCause::kKernelDrops] ==
        kSent + 1);
}

TEST_CASE("a port that is taken is refused by its number") {
  const UdpSource source = open_source();
  const auto second = UdpSource::open({.port = source.port(), .address = "127.0.0.1"});
  REQUIRE_FALSE(second.has_value());
  CHECK(second.error().kind == ErrorKind::kResource);
  CHECK(second.error().message.find(std::to_string(source.port())) != std::string::npos);
}

TEST_CASE("a sender goes on when nobody has listened yet") {
  UdpSource first = open_source();
  UdpSender sender = open_sender(first);
  const std::uint16_t port = first.port();
  { const UdpSource closed = std::move(first); }
  const std::vector<std::byte> payload(100);
  (void)sender.send(payload);
  (void)sender.send(payload);
  auto late = UdpSource::open({.port = port, .address = "127.0.0.1"});
  REQUIRE(late.has_value());
  CHECK(sender.send(payload));
  UdpDatagram datagram;
  CHECK(late->next(datagram));
}

}  // namespace
}  // namespace cloister
