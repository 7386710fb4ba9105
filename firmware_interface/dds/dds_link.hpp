#pragma once

#include <cstdint>
#include <string>

#include "firmware_interface/dds/dds_options.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// This process's place in the DDS domain: one participant. Topics are made on it and must end before it.
///
/// Threads: Cyclone has its own. Open it while the process has only one (see roudi_probe.hpp).
class DdsLink {
 public:
  /// Decides on shared memory within two seconds, and joins the domain.
  /// @return kResource when the domain cannot be joined, or shared memory is demanded and cannot be had
  [[nodiscard]] static Result<DdsLink> open(const DdsOptions& options);

  DdsLink(DdsLink&& other) noexcept;
  DdsLink& operator=(DdsLink&& other) noexcept;
  ~DdsLink();

  [[nodiscard]] bool uses_shared_memory() const { return uses_shared_memory_; }
  /// Whoever is heard runs on this host, and goes by its clock.
  [[nodiscard]] bool stays_on_host() const { return stays_on_host_; }
  /// One line: what scans go through, and why.
  [[nodiscard]] const std::string& transport() const { return transport_; }
  /// Cyclone's handle, a dds_entity_t.
  [[nodiscard]] std::int32_t participant() const { return participant_; }

 private:
  DdsLink() = default;

  std::int32_t domain_ = 0;
  std::int32_t participant_ = 0;
  bool uses_shared_memory_ = false;
  bool stays_on_host_ = false;
  std::string transport_;
};

}  // namespace cloister
