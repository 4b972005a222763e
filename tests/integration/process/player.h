// Player: one client over real sockets, without a bot: it logs in, sends commands, waits for
// events.
#pragma once

#include "client-sim/link/client.h"
#include "client-sim/link/socket_transport.h"
#include "proto/sandbox.pb.h"

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace zoned::testing_process {

class Player final : public link::SessionHandler {
  public:
    /// `ticket` holds a serialised ticket; empty: development mode.
    Player(int tcp_port, const std::string& name, const std::string& ticket)
        : network_({"127.0.0.1", std::to_string(tcp_port), insecure(), "", 1}),
          transport_(network_.make_transport()),
          client_(*transport_, *this, {name, "", ticket, ""}) {
        client_.start(now());
    }

    void on_welcome(const wire::WelcomeMessage&) override {}

    void on_joined(const wire::JoinedMessage& joined) override { avatar = joined.avatar; }

    void on_event(const wire::EventMessage& event) override {
        if (event.kind == sandbox::EVENT_INVENTORY) {
            inventory.ParseFromString(event.payload);
            ++inventories;
        }
        if (event.kind == sandbox::EVENT_LEDGER) {
            ledger.ParseFromString(event.payload);
        }
    }

    void on_audit(const wire::AuditRecordMessage&) override {}

    bool on_packet(const link::OpenedPacket&) override { return true; }

    /// Goes on until `done`; false after `seconds` or when the session has ended.
    bool run_until(const std::function<bool()>& done, double seconds) {
        const double end = now() + seconds;
        while (!done()) {
            if (now() > end || client_.state() == link::SessionState::kClosed) {
                return false;
            }
            network_.poll(now());
            client_.advance(now());
            network_.flush();
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return true;
    }

    bool join(double seconds) {
        return run_until([this] { return avatar != 0; }, seconds);
    }

    void pick_up(std::uint32_t entity) {
        sandbox::PickUp command;
        command.set_entity(entity);
        client_.send_command(sandbox::COMMAND_PICK_UP, command.SerializeAsString());
    }

    void quit() { client_.quit(now()); }

    [[nodiscard]] const std::string& trouble() const { return client_.trouble(); }

    std::uint32_t avatar = 0;
    sandbox::Inventory inventory;  ///< the newest that came
    sandbox::Ledger ledger;        ///< likewise
    int inventories = 0;

  private:
    static link::Trust insecure() {
        link::Trust trust;
        trust.kind = link::Trust::TrustKind::kInsecure;
        return trust;
    }

    static double now() {
        using Clock = std::chrono::steady_clock;
        return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
    }

    link::SocketNetwork network_;
    std::unique_ptr<link::SocketTransport> transport_;
    link::Client client_;
};

}  // namespace zoned::testing_process
