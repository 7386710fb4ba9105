#include "firmware_interface/ouster/udp_source.hpp"

#include <netdb.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>

namespace cloister {
namespace {

constexpr unsigned kBatch = 32;
// The longest lidar packet, 128 beams of dual returns, has 33,088 bytes; a datagram cannot have more than 65,535.
constexpr std::size_t kMaxPayloadBytes = 65'536;

std::string failure(const std::string& what) { return what + ": " + std::strerror(errno); }

/// Asks for a receive buffer, past the system's limit where that is permitted. Returns what was granted.
int size_receive_buffer(int fd, int bytes) {
  if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof(bytes)) != 0) {
    (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof(bytes));
  }
  int granted = 0;
  socklen_t size = sizeof(granted);
  (void)getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &granted, &size);
  return granted;
}

}  // namespace

struct UdpSource::Batch {
  std::vector<std::byte> payloads = std::vector<std::byte>(kBatch * kMaxPayloadBytes);
  std::array<mmsghdr, kBatch> messages{};
  std::array<iovec, kBatch> buffers{};
  std::array<sockaddr_in, kBatch> senders{};
  struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(timespec))> bytes;
  };
  std::array<Control, kBatch> controls{};
  unsigned received = 0;
  unsigned next = 0;
};

Result<UdpSource> UdpSource::open(const Options& options) {
  const std::string name = "UDP port " + std::to_string(options.port);
  UdpSource source;
  source.fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (source.fd_ < 0) return fail(ErrorKind::kResource, failure(name + ": cannot make a socket"));
  source.granted_bytes_ = size_receive_buffer(source.fd_, options.receive_buffer_bytes);
  const int on = 1;
  (void)setsockopt(source.fd_, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof(on));
  (void)setsockopt(source.fd_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof(on));

  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options.port);
  if (!options.address.empty() &&
      inet_pton(AF_INET, options.address.c_str(), &address.sin_addr) != 1) {
    return fail(ErrorKind::kUsage,
                name + ": \"" + options.address + "\" is no IPv4 address of an interface");
  }
  if (bind(source.fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    return fail(ErrorKind::kResource,
                failure(name + ": cannot listen") + "; is another reader of this sensor running?");
  }
  socklen_t size = sizeof(address);
  (void)getsockname(source.fd_, reinterpret_cast<sockaddr*>(&address), &size);
  source.port_ = ntohs(address.sin_port);

  source.batch_ = std::make_unique<Batch>();
  Batch& batch = *source.batch_;
  for (unsigned i = 0; i < kBatch; ++i) {
    batch.buffers[i] = {batch.payloads.data() + i * kMaxPayloadBytes, kMaxPayloadBytes};
    batch.messages[i].msg_hdr.msg_iov = &batch.buffers[i];
    batch.messages[i].msg_hdr.msg_iovlen = 1;
    batch.messages[i].msg_hdr.msg_name = &batch.senders[i];
    batch.messages[i].msg_hdr.msg_control = batch.controls[i].bytes.data();
  }
  return source;
}

UdpSource::UdpSource(UdpSource&& other) noexcept { *this = std::move(other); }

UdpSource& UdpSource::operator=(UdpSource&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(port_, other.port_);
  std::swap(granted_bytes_, other.granted_bytes_);
  std::swap(batch_, other.batch_);
  std::swap(drops_seen_, other.drops_seen_);
  std::swap(counters_, other.counters_);
  return *this;
}

UdpSource::~UdpSource() {
  if (fd_ >= 0) close(fd_);
}

bool UdpSource::refill() {
  Batch& batch = *batch_;
  for (mmsghdr& message : batch.messages) {
    message.msg_hdr.msg_namelen = sizeof(sockaddr_in);
    message.msg_hdr.msg_controllen = sizeof(Batch::Control);
  }
  const int received = recvmmsg(fd_, batch.messages.data(), kBatch, MSG_DONTWAIT, nullptr);
  batch.next = 0;
  batch.received = static_cast<unsigned>(std::max(received, 0));
  if (received < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
    counters_.add(SocketCause::kReceiveErrors);
  return received > 0;
}

bool UdpSource::next(UdpDatagram& datagram) {
  while (true) {
    if (batch_->next == batch_->received && !refill()) return false;
    const unsigned i = batch_->next++;
    msghdr& header = batch_->messages[i].msg_hdr;
    datagram.capture_time_ns = 0;
    for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr;
         control = CMSG_NXTHDR(&header, control)) {
      if (control->cmsg_level != SOL_SOCKET) continue;
      if (control->cmsg_type == SO_RXQ_OVFL) {
        std::uint32_t drops = 0;
        std::memcpy(&drops, CMSG_DATA(control), sizeof(drops));
        counters_.add(SocketCause::kKernelDrops, drops - drops_seen_);
        drops_seen_ = drops;
      } else if (control->cmsg_type == SO_TIMESTAMPNS) {
        timespec time{};
        std::memcpy(&time, CMSG_DATA(control), sizeof(time));
        datagram.capture_time_ns = time.tv_sec * 1'000'000'000LL + time.tv_nsec;
      }
    }
    if ((header.msg_flags & MSG_TRUNC) != 0) {
      counters_.add(SocketCause::kOversized);
      continue;
    }
    counters_.add(SocketCause::kDatagrams);
    datagram.source_address = ntohl(batch_->senders[i].sin_addr.s_addr);
    datagram.source_port = ntohs(batch_->senders[i].sin_port);
    datagram.destination_port = port_;
    datagram.payload = {batch_->payloads.data() + i * kMaxPayloadBytes,
                        batch_->messages[i].msg_len};
    return true;
  }
}

Result<UdpSender> UdpSender::open(const std::string& host, std::uint16_t port) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
      error != 0) {
    return fail(ErrorKind::kInput, host + ": cannot be found: " + gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, &freeaddrinfo);
  UdpSender sender;
  sender.fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (sender.fd_ < 0 || connect(sender.fd_, addresses->ai_addr, addresses->ai_addrlen) != 0) {
    return fail(ErrorKind::kResource, failure(host + ": cannot be sent to"));
  }
  return sender;
}

UdpSender::UdpSender(UdpSender&& other) noexcept { std::swap(fd_, other.fd_); }

UdpSender& UdpSender::operator=(UdpSender&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

UdpSender::~UdpSender() {
  if (fd_ >= 0) close(fd_);
}

bool UdpSender::send(std::span<const std::byte> payload) {
  // A refused packet reports the one before it, whose reader was not there yet: the present one is still to be sent.
  const auto sent = [&] {
    return ::send(fd_, payload.data(), payload.size(), 0) == static_cast<ssize_t>(payload.size());
  };
  return sent() || (errno == ECONNREFUSED && sent());
}

}  // namespace cloister
