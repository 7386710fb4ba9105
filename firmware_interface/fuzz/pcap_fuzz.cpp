// Any bytes as a capture: refused, or read to its end with every payload inside its bounds.

#include <cstdint>
#include <span>

#include "firmware_interface/ouster/pcap_source.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cloister::Result<cloister::PcapSource> source =
      cloister::PcapSource::from_memory(std::as_bytes(std::span(data, size)), "capture");
  if (!source) return 0;
  cloister::UdpDatagram datagram;
  volatile unsigned sum = 0;
  while (true) {
    const cloister::Result<bool> more = source->next(datagram);
    if (!more || !*more) break;
    for (const std::byte byte : datagram.payload) sum = sum + std::to_integer<unsigned>(byte);
  }
  return 0;
}
