// ServerStore: the store that a config asks for, wired to the world and the sessions of a server.
#pragma once

#include "server/app/storage/held_output.h"
#include "server/config/settings.h"
#include "server/session/host/session_host.h"
#include "server/store/store_service.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::app {

/// How the store of a config is opened, also by commands. Throws std::runtime_error.
std::unique_ptr<store::Store> open_store(const config::StoreSettings& settings);

class ServerStore {
  public:
    struct Output {
        /// To the inbox of the world; from any thread.
        std::function<void(mailbox::StoreAnswer)> answer;
        /// See store::StoreServiceOutput; on the writer's thread.
        std::function<void(std::uint64_t number)> durable;
    };

    /// Opens the store and reads what logins need. Throws std::runtime_error that says what to do.
    explicit ServerStore(const config::Settings& settings);

    [[nodiscard]] bool on() const { return store_ != nullptr || service_ != nullptr; }

    /// Gives the sessions the bans and used tickets of before, and begins to write.
    void start(session::SessionHost& host, Output output);
    /// Writes what waits. Returns how many changes the store did not take.
    std::uint64_t stop();

    // From any thread, after start().

    /// The requests of a tick.
    StoreTicket submit(Tick tick, std::vector<mailbox::StoreRequest>&& requests);
    void log_in(const session::LoginToStore& login,
                std::function<void(const store::LoginResult&)> done);
    /// The records of an account, once all that was asked before is durable; none where they
    /// cannot be read. Without a store there are none. `done` is called from any thread.
    void read_records(const std::string& account,
                      std::function<void(std::optional<std::vector<store::PutRecord>>)> done);
    /// `done` is called, from any thread, when Output::durable has told of all that was asked
    /// before.
    void settle(std::function<void()> done);
    /// In place of all records of the account. `done` gets false where the store takes no more.
    void replace_records(const std::string& account,
                         std::vector<store::PutRecord> records,
                         std::function<void(bool)> done);
    /// `done` gets the reason why it does not last, or an empty text; from any thread.
    void change(store::StoreChange change, std::function<void(const std::string&)> done);
    /// None without a store.
    [[nodiscard]] std::optional<store::StoreFigures> figures() const;

  private:
    config::StoreSettings settings_;
    std::string world_;
    std::unique_ptr<store::Store> store_;  // until start()
    std::vector<store::PutBan> bans_;
    std::vector<store::UseTicket> tickets_;
    Output output_;
    std::unique_ptr<store::StoreService> service_;
};

}  // namespace zoned::app
