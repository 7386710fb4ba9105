#include "firmware_interface/dds/dds_link.hpp"

#include <cloister_native.h>

#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include <dds/dds.h>

#include "firmware_interface/dds/roudi_probe.hpp"

namespace cloister {
namespace {

// A healthy daemon answers in 10 ms, a machine under load may take its time: within two seconds the choice is made.
constexpr std::chrono::milliseconds kProbeTimeout{1500};

// What ROS 2's tools look for in a participant's user data.
constexpr std::string_view kUserData = "enclave=/;";

}  // namespace

Result<DdsLink> DdsLink::open(const DdsOptions& options) {
  RouDiState daemon;
  daemon.reason = "it is switched off";
  if (options.shared_memory != SharedMemoryUse::kOff) {
    daemon = probe_roudi(sizeof(cloister_wire_OrganisedScan), kProbeTimeout);
    if (!daemon.is_usable && options.shared_memory == SharedMemoryUse::kOn) {
      return fail(ErrorKind::kResource, "shared memory cannot be used: " + daemon.reason +
                                            "; start it, or set dds.shared_memory to \"auto\"");
    }
  }
  const std::string xml =
      cyclone_xml(options, daemon.is_usable ? std::optional(daemon.locator) : std::nullopt);
  const auto domain_id = static_cast<dds_domainid_t>(options.domain);
  const auto failed = [&](dds_return_t error) {
    return fail(ErrorKind::kResource, "DDS domain " + std::to_string(options.domain) +
                                          " cannot be joined over \"" + options.interface +
                                          "\": " + dds_strretcode(-error) +
                                          "; check dds.interface and whether the ports from " +
                                          std::to_string(options.first_port) + " on are free");
  };
  DdsLink link;
  link.domain_ = dds_create_domain(domain_id, xml.c_str());
  if (link.domain_ < 0) return failed(std::exchange(link.domain_, 0));
  const std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> qos(dds_create_qos(),
                                                                  &dds_delete_qos);
  dds_qset_userdata(qos.get(), kUserData.data(), kUserData.size());
  link.participant_ = dds_create_participant(domain_id, qos.get(), nullptr);
  if (link.participant_ < 0) return failed(std::exchange(link.participant_, 0));
  link.uses_shared_memory_ = daemon.is_usable;
  link.stays_on_host_ = options.interface == "lo" || options.interface.starts_with("127.");
  link.transport_ = daemon.is_usable
                        ? "scans through shared memory where both sides have it, all else over UDP"
                        : "everything over UDP, no shared memory: " + daemon.reason;
  return link;
}

DdsLink::DdsLink(DdsLink&& other) noexcept { *this = std::move(other); }

DdsLink& DdsLink::operator=(DdsLink&& other) noexcept {
  std::swap(domain_, other.domain_);
  std::swap(participant_, other.participant_);
  std::swap(uses_shared_memory_, other.uses_shared_memory_);
  std::swap(stays_on_host_, other.stays_on_host_);
  std::swap(transport_, other.transport_);
  return *this;
}

DdsLink::~DdsLink() {
  if (participant_ > 0) dds_delete(participant_);
  if (domain_ > 0) dds_delete(domain_);
}

}  // namespace cloister
