#include "firmware_interface/dds/dds_options.hpp"

#include <sstream>

namespace cloister {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string peer_list(const DdsOptions& options) {
  // Alone on this machine: where else should the others be?
  std::istringstream text(options.peers.empty() && options.interface == "lo" ? "127.0.0.1"
                                                                             : options.peers);
  std::string list;
  for (std::string peer; std::getline(text, peer, ',');) {
    if (!peer.empty()) list += "<Peer Address=\"" + escaped(peer) + "\"/>";
  }
  return list;
}

}  // namespace

std::string cyclone_xml(const DdsOptions& options, const std::optional<std::string>& locator) {
  std::ostringstream xml;
  const char* multicast = options.multicast ? "true" : "false";
  xml << "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface ";
  if (options.interface.empty()) {
    xml << "autodetermine=\"true\"";
  } else if (options.interface.find('.') != std::string::npos) {
    xml << "address=\"" << escaped(options.interface) << "\"";
  } else {
    xml << "name=\"" << escaped(options.interface) << "\"";
  }
  xml << " multicast=\"" << multicast << "\"/></Interfaces><AllowMulticast>" << multicast
      << "</AllowMulticast><ExternalNetworkAddress>"
      << (options.external_address.empty() ? "auto" : escaped(options.external_address))
      << "</ExternalNetworkAddress>"
      // The fastest for scans of 350 kB over UDP; fragments of datagrams are the loopback's own affair.
      << "<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>4000B</FragmentSize></General>"
      // Without multicast every participant needs an index of its own, and by default the tenth would get none.
      << "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</"
         "MaxAutoParticipantIndex>"
      << "<Ports><Base>" << options.first_port << "</Base></Ports><Peers>" << peer_list(options)
      << "</Peers></Discovery>"
      // More than all scans that a writer keeps, so that it never waits for a reader that stands still, at the cost of
      // the others; less than all parts of graphs that it keeps, so that it does wait before it forgets one.
      << "<Internal><SocketReceiveBufferSize "
         "min=\"2MB\"/><Watermarks><WhcHigh>16MB</WhcHigh></Watermarks></Internal>"
      // Else a file appears wherever the program is started.
      << "<Tracing><Verbosity>severe</Verbosity><OutputFile>stderr</OutputFile></Tracing>"
      << "<SharedMemory><Enable>" << (locator ? "true" : "false") << "</Enable>";
  if (locator) xml << "<Locator>" << *locator << "</Locator><LogLevel>warn</LogLevel>";
  xml << "</SharedMemory></Domain></CycloneDDS>";
  return xml.str();
}

}  // namespace cloister
