#include "client-sim/web/web_verdict.h"

namespace zoned::web {

namespace {

/// As often as for bots.
constexpr double kPeriodS = 0.1;

}  // namespace

const std::string& WebVerdict::text() {
    text_.clear();
    if (game_.player() != nullptr && tally_.samples > 0) {
        audit::AuditVerdict verdict;
        audit::SessionFaults faults;
        faults.add(player());
        audit::judge(tally_, true, verdict);
        audit::judge(faults, verdict);
        text_ = verdict.text();
    }
    return text_;
}

void WebVerdict::on_session(const wire::WelcomeMessage& /*welcome*/) {
    client_.on_session(player());
    auditor_.restart();
    next_s_ = 0.0;
}

void WebVerdict::on_new_view() {
    client_.on_new_view(player());
    auditor_.restart();
}

void WebVerdict::on_joined(const wire::JoinedMessage& joined) {
    client_.on_joined(player(), joined);
    auditor_.restart();
}

void WebVerdict::on_set_back() {
    client_.on_set_back(player());
    auditor_.restart();
}

void WebVerdict::on_audit(const wire::AuditRecordMessage& record) {
    auditor_.add(record);
}

void WebVerdict::on_packet(const link::OpenedPacket& packet, const view::PacketResult& taken) {
    client_.on_packet(player(), packet, taken);
    if (!player().ready()) {
        return;
    }
    client_.settle(player());
    if (player().now_s() >= next_s_) {
        next_s_ = player().now_s() + kPeriodS;
        auditor_.settle(player(), client_, tally_);
    }
}

}  // namespace zoned::web
