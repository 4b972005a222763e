// WebVerdict: judges what a page displays by the rules by which client-sim judges its bots.
#pragma once

#include "client-sim/audit/audit_verdict.h"
#include "client-sim/audit/audited_client.h"
#include "client-sim/audit/auditor.h"
#include "client-sim/library/game_client.h"

#include <string>

namespace zoned::web {

/// The library asks for the audits, where the session may.
class WebVerdict final : public view::PlayerObserver {
  public:
    explicit WebVerdict(const library::GameClient& game) : game_(game) {}

    [[nodiscard]] const audit::Tally& tally() const { return tally_; }

    /// "consistent", or "inconsistent" with its reasons; empty: nothing was compared.
    [[nodiscard]] const std::string& text();

    void on_session(const wire::WelcomeMessage& welcome) override;
    void on_new_view() override;
    void on_joined(const wire::JoinedMessage& joined) override;
    void on_set_back() override;
    void on_audit(const wire::AuditRecordMessage& record) override;
    void on_packet(const link::OpenedPacket& packet, const view::PacketResult& taken) override;

  private:
    /// Observers hear nothing without a player.
    [[nodiscard]] const view::Player& player() const { return *game_.player(); }

    const library::GameClient& game_;
    audit::AuditedClient client_;
    audit::Auditor auditor_{0};
    audit::Tally tally_;
    double next_s_ = 0.0;
    std::string text_;
};

}  // namespace zoned::web
