#pragma once

#include <optional>
#include <string>

namespace cloister {

/// Whether scans may go through shared memory.
enum class SharedMemoryUse {
  kAuto,  ///< where its daemon answers, else over UDP
  kOn,    ///< or not at all
  kOff,
};

/// How this process joins the DDS domain.
struct DdsOptions {
  int domain = 0;
  std::string interface = "lo";  ///< name or address; empty: whichever Cyclone prefers
  std::string
      peers;  ///< addresses to look for others at, separated by commas; needed without multicast
  /// Where others reach this process when the network on the way translates addresses; empty: where it is. Ports must
  /// stay what they are, and the interface must be another than loopback.
  std::string external_address;
  bool multicast = false;
  int first_port = 7400;  ///< the domain uses the 100 ports from here on
  SharedMemoryUse shared_memory = SharedMemoryUse::kAuto;
};

/// The configuration that Cyclone DDS gets for these options.
/// @param locator  set when shared memory is to be used: what tells one instance of its daemon from another
[[nodiscard]] std::string cyclone_xml(const DdsOptions& options,
                                      const std::optional<std::string>& locator);

}  // namespace cloister
