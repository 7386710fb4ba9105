#include "firmware_interface/ouster/ipv4_reassembler.hpp"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <doctest/doctest.h>

using namespace cloister;

namespace {

using Bytes = std::vector<std::byte>;

Bytes pattern(int size, int seed) {
  Bytes bytes(static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 31 + i / 256 + seed);
  return bytes;
}

// The fragments of a datagram, in order; each but the last carries `unit` bytes.
std::vector<Ipv4Fragment> cut(const Bytes& datagram, int id, int unit = 1480,
                              std::int64_t time_ns = 0) {
  std::vector<Ipv4Fragment> fragments;
  const int size = static_cast<int>(datagram.size());
  for (int at = 0; at < size; at += unit) {
    const int length = std::min(unit, size - at);
    fragments.push_back({.source_address = 1,
                         .destination_address = 2,
                         .id = static_cast<std::uint16_t>(id),
                         .offset = at,
                         .more = at + length < size,
                         .capture_time_ns = time_ns,
                         .payload = std::span(datagram).subspan(at, length)});
  }
  return fragments;
}

Bytes add_all(Ipv4Reassembler& reassembler, const std::vector<Ipv4Fragment>& fragments) {
  Bytes whole;
  for (const Ipv4Fragment& fragment : fragments) {
    const auto result = reassembler.add(fragment);
    if (!result.empty()) whole.assign(result.begin(), result.end());
  }
  return whole;
}

}  // namespace

TEST_CASE("a datagram comes back whole, whatever the order of its fragments") {
  const Bytes datagram = pattern(12616, 1);
  std::mt19937 random(7);
  Ipv4Reassembler reassembler;
  for (int round = 0; round < 50; ++round) {
    std::vector<Ipv4Fragment> fragments = cut(datagram, round);
    if (round > 0) std::shuffle(fragments.begin(), fragments.end(), random);
    CHECK(add_all(reassembler, fragments) == datagram);
  }
  CHECK(reassembler.incomplete_datagrams() == 0);
  CHECK(reassembler.malformed_fragments() == 0);
}

TEST_CASE("fragments of several datagrams may be mixed") {
  const Bytes first = pattern(5000, 1);
  const Bytes second = pattern(5000, 2);
  const auto a = cut(first, 10);
  const auto b = cut(second, 11);
  Ipv4Reassembler reassembler;
  for (std::size_t i = 0; i + 1 < a.size(); ++i) {
    CHECK(reassembler.add(a[i]).empty());
    CHECK(reassembler.add(b[i]).empty());
  }
  const auto whole_a = reassembler.add(a.back());
  CHECK(std::equal(whole_a.begin(), whole_a.end(), first.begin(), first.end()));
  const auto whole_b = reassembler.add(b.back());
  CHECK(std::equal(whole_b.begin(), whole_b.end(), second.begin(), second.end()));
}

TEST_CASE("a repeated fragment changes nothing and is counted") {
  const Bytes datagram = pattern(5000, 1);
  auto fragments = cut(datagram, 3);
  fragments.insert(fragments.begin() + 1, fragments[0]);
  fragments.insert(fragments.begin() + 3, fragments[2]);
  Ipv4Reassembler reassembler;
  CHECK(add_all(reassembler, fragments) == datagram);
  CHECK(reassembler.repeated_fragments() == 2);
  CHECK(reassembler.incomplete_datagrams() == 0);
}

TEST_CASE("a stray of an older datagram with the same id gives way to the new one") {
  const Bytes older = pattern(5000, 9);
  const Bytes datagram = pattern(5000, 1);
  Ipv4Reassembler reassembler;

  SUBCASE("long ago") {
    CHECK(reassembler.add(cut(older, 3)[0]).empty());
    CHECK(add_all(reassembler, cut(datagram, 3, 1480, 88'000'000'000)) == datagram);
    CHECK(reassembler.incomplete_datagrams() == 1);
  }
  SUBCASE("a moment ago, its first fragment") {
    CHECK(reassembler.add(cut(older, 3)[0]).empty());
    CHECK(add_all(reassembler, cut(datagram, 3)) == datagram);
    CHECK(reassembler.incomplete_datagrams() == 1);
  }
  SUBCASE("a moment ago, all but its last fragment") {
    auto strays = cut(older, 3);
    strays.pop_back();
    CHECK(add_all(reassembler, strays).empty());
    CHECK(add_all(reassembler, cut(datagram, 3)) == datagram);
    CHECK(reassembler.incomplete_datagrams() == 1);
  }
  SUBCASE("a moment ago, one from its middle") {
    CHECK(reassembler.add(cut(older, 3)[1]).empty());
    CHECK(add_all(reassembler, cut(datagram, 3)) == datagram);
  }
}

TEST_CASE("fragments that contradict each other never make a datagram") {
  const Bytes datagram = pattern(4000, 1);
  const auto fragments = cut(datagram, 3, 800);
  Ipv4Reassembler reassembler;
  SUBCASE("a partial overlap") {
    Ipv4Fragment shifted = fragments[1];
    shifted.offset += 400;
    CHECK(reassembler.add(fragments[0]).empty());
    CHECK(reassembler.add(fragments[1]).empty());
    CHECK(reassembler.add(shifted).empty());
  }
  SUBCASE("two ends") {
    Ipv4Fragment end = fragments[3];
    end.more = false;
    CHECK(reassembler.add(fragments[4]).empty());
    CHECK(reassembler.add(end).empty());
  }
  SUBCASE("a fragment past the end") {
    Ipv4Fragment end = fragments[2];
    end.more = false;
    CHECK(reassembler.add(end).empty());
    CHECK(reassembler.add(fragments[3]).empty());
  }
  CHECK(reassembler.incomplete_datagrams() == 1);
}

TEST_CASE("fragments that cannot be placed are counted") {
  const Bytes bytes = pattern(1480, 1);
  Ipv4Fragment fragment = cut(bytes, 3)[0];
  Ipv4Reassembler reassembler;
  fragment.more = true;
  fragment.payload = std::span(bytes).first(1001);  // not a multiple of eight, yet not the last
  CHECK(reassembler.add(fragment).empty());
  fragment.payload = {};
  CHECK(reassembler.add(fragment).empty());
  fragment.payload = bytes;
  fragment.offset = 65528;  // past the largest datagram
  CHECK(reassembler.add(fragment).empty());
  CHECK(reassembler.malformed_fragments() == 3);
}

TEST_CASE("the datagram begun first is given up when every buffer is in use") {
  const Bytes datagram = pattern(5000, 1);
  Ipv4Reassembler reassembler;
  for (int id = 0; id <= Ipv4Reassembler::kMaxDatagrams; ++id) {
    CHECK(reassembler.add(cut(datagram, id)[0]).empty());
  }
  CHECK(reassembler.incomplete_datagrams() == 1);
  auto rest = cut(datagram, 1);
  rest.erase(rest.begin());
  CHECK(add_all(reassembler, rest) == datagram);
  rest = cut(datagram, 0);
  rest.erase(rest.begin());
  CHECK(add_all(reassembler, rest).empty());
  reassembler.clear();
  CHECK(reassembler.incomplete_datagrams() == 1 + Ipv4Reassembler::kMaxDatagrams);
}
