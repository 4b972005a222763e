#include "server/app/runtime/start_log.h"

#include "server/app/log/log.h"
#include "server/app/log/session_log.h"
#include "server/app/runtime/host_settings.h"
#include "server/app/runtime/network.h"
#include "server/config/expand/world_warnings.h"
#include "server/mailbox/messages.h"

namespace zoned::app {

namespace {

void add_development(const config::Settings& settings, std::vector<std::string>& out) {
    const config::SessionSettings& session = settings.server.session;
    if (!session.dev_mode_loopback) {
        return;
    }
    const std::uint32_t rights = session.dev_rights.value_or(mailbox::kRightPlay);
    std::string text =
        "session.dev_mode_loopback: everybody on this machine may play without a "
        "ticket, with the rights " +
        rights_text(rights);
    if ((rights & mailbox::kRightAudit) != 0) {
        text += "; AUDIT shows hidden entities";
    }
    if ((rights & mailbox::kRightFreeze) != 0) {
        text += "; FREEZE stops the world for all";
    }
    out.push_back(std::move(text));
    const std::string& address = settings.server.network.bind_address;
    if (address == "::" || address == "0.0.0.0") {
        out.push_back("network.bind_address: " + address +
                      " takes connections from all networks while the development mode is on; "
                      "others still need a ticket, but a proxy on this machine makes everybody "
                      "local");
    }
}

void add_faults(const config::Settings& settings, std::vector<std::string>& out) {
    for (const std::string& fault : config::testing_faults_of(settings)) {
        out.push_back("testing." + fault + ": this server makes faults on purpose");
    }
}

}  // namespace

std::vector<std::string> unusual_of(const config::Settings& settings) {
    std::vector<std::string> out;
    const config::ListenSettings& network = settings.server.network;
    const config::SessionSettings& session = settings.server.session;
    add_development(settings, out);
    if (session.tls_certificate_file.empty()) {
        out.push_back(
            "session.tls_certificate_file: none is set; clients must pin the certificate "
            "that was made in " +
            session.state_folder);
    }
    if (network.admin && !admin_is_local(settings)) {
        out.push_back("network.admin_address: " + network.admin_address +
                      " lets other machines reach the admin server, by TLS, with its token");
    }
    if (network.websocket_port && session.tls_certificate_file.empty() &&
        !is_loopback_address(network.websocket_address)) {
        out.push_back(
            "network.websocket_address: " + network.websocket_address +
            " is reached by TLS, and browsers do not trust the certificate that was made: "
            "set session.tls_certificate_file");
    }
    add_faults(settings, out);
    if (settings.server.store.kind == config::StoreKind::kNone) {
        out.push_back(
            "store.kind: STORE_NONE: a restart forgets bans, used tickets and what the rules keep");
    }
    if (!settings.server.recording_file.empty()) {
        out.push_back("recording.file: all inputs go to " + settings.server.recording_file);
    }
    return out;
}

void log_start(const config::Settings& settings) {
    for (const std::string& text : unusual_of(settings)) {
        log_of(LogArea::kServer).warn("{}", text);
    }
}

mailbox::CodecPrice logged(const mailbox::CodecPrice& price) {
    log_of(LogArea::kServer)
        .info("coding for one client: {} ns a record and {} ns a packet",
              price.record_ns,
              price.packet_ns);
    return price;
}

std::string addresses_text(const config::AdvertiseSettings& advertised, const Network& network) {
    const std::uint16_t web = network.websocket_port();
    const std::string websocket = web == 0 ? "" : fmt::format(" websocket={}", web);
    if (advertised == config::AdvertiseSettings{}) {
        return websocket;
    }
    return websocket +
           fmt::format(" address={} public_tcp={} public_udp={}",
                       advertised.address.empty() ? "-" : advertised.address,
                       advertised.tcp_port == 0 ? network.tcp_port() : advertised.tcp_port,
                       advertised.udp_port == 0 ? network.udp_port() : advertised.udp_port);
}

}  // namespace zoned::app
