#include "server/app/storage/server_store.h"

#include "server/app/log/log.h"
#include "server/store/postgres_store.h"
#include "server/store/sqlite_store.h"

#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace zoned::app {

namespace {

template <class T>
T value_or_throw(store::StoreResult<T> result) {
    if (!result.ok()) {
        throw std::runtime_error(result.error().text);
    }
    return std::move(*result);
}

void log_trouble(const std::string& text) {
    if (text.empty()) {
        log_of(LogArea::kServer).warn("the store works again; all that waited for it is written");
    } else {
        log_of(LogArea::kServer)
            .error("the store fails, the server goes on and tries again: {}", text);
    }
}

}  // namespace

std::unique_ptr<store::Store> open_store(const config::StoreSettings& settings) {
    if (settings.kind == config::StoreKind::kPostgresql) {
        return value_or_throw(store::open_postgres_store(settings.url, true));
    }
    std::error_code ignored;
    std::filesystem::create_directories(std::filesystem::path(settings.file).parent_path(),
                                        ignored);
    return value_or_throw(store::open_sqlite_store(
        settings.file,
        settings.durability == config::StoreDurability::kPower ? store::Durability::kPower
                                                               : store::Durability::kProcess));
}

ServerStore::ServerStore(const config::Settings& settings)
    : settings_(settings.server.store),
      world_(settings.digest) {
    if (settings_.kind == config::StoreKind::kNone) {
        return;
    }
    store_ = open_store(settings_);
    const std::int64_t now = std::time(nullptr);
    const std::vector<store::StoreChange> old{store::ForgetTickets{now}};
    value_or_throw(store_->commit(old));
    bans_ = value_or_throw(store_->bans());
    tickets_ = value_or_throw(store_->tickets(now));
}

void ServerStore::start(session::SessionHost& host, Output output) {
    output_ = std::move(output);
    for (const store::PutBan& ban : bans_) {
        host.ban({ban.account, ban.until_unix_s, ban.reason});
    }
    for (const store::UseTicket& ticket : tickets_) {
        host.remember_ticket(ticket.nonce, ticket.expires_s);
    }
    bans_.clear();
    tickets_.clear();
    if (store_ == nullptr) {
        return;
    }
    store::StoreServiceSettings service;
    service.max_waiting_bytes = static_cast<std::size_t>(settings_.max_waiting_mb) << 20U;
    service.world = world_;
    std::function<store::StoreResult<bool>()> checkpoint;
    if (settings_.kind == config::StoreKind::kSqlite) {
        checkpoint = [mover = std::make_shared<store::SqliteCheckpoint>(settings_.file)] {
            return mover->run();
        };
    }
    service_ = std::make_unique<store::StoreService>(
        std::move(store_),
        service,
        store::StoreServiceOutput{output_.answer, output_.durable, &log_trouble},
        checkpoint);
}

std::uint64_t ServerStore::stop() {
    if (!service_) {
        return 0;
    }
    service_->stop();
    const store::StoreFigures figures = service_->figures();
    if (figures.lost > 0) {
        log_of(LogArea::kServer)
            .error("the store did not take {} changes before the server ended: {}",
                   figures.lost,
                   figures.failing);
    }
    return figures.lost;
}

StoreTicket ServerStore::submit(Tick tick, std::vector<mailbox::StoreRequest>&& requests) {
    if (service_) {
        const std::uint64_t number = service_->submit(tick, std::move(requests));
        return {number, number == 0};
    }
    for (const mailbox::StoreRequest& request : requests) {
        if (request.number != 0) {
            output_.answer(store::answer_to(request, mailbox::StoreStatus::kRefused));
        }
    }
    return {};
}

void ServerStore::log_in(const session::LoginToStore& login,
                         std::function<void(const store::LoginResult&)> done) {
    service_->log_in({login.account, login.character, login.unix_s},
                     store::UseTicket{login.nonce, login.expires_s},
                     std::move(done));
}

void ServerStore::read_records(
    const std::string& account,
    std::function<void(std::optional<std::vector<store::PutRecord>>)> done) {
    if (service_) {
        service_->read_records(account, std::move(done));
    } else {
        done(std::vector<store::PutRecord>());
    }
}

void ServerStore::settle(std::function<void()> done) {
    if (!service_) {
        done();
        return;
    }
    // Of a batch all jobs are answered before it is told of. So the first may come too early; what
    // is asked from within its answer belongs to a later batch.
    service_->submit({}, [this, done = std::move(done)](bool) mutable {
        service_->submit({}, [done = std::move(done)](bool) { done(); });
    });
}

void ServerStore::replace_records(const std::string& account,
                                  std::vector<store::PutRecord> records,
                                  std::function<void(bool)> done) {
    if (!service_) {
        done(true);
        return;
    }
    std::vector<store::StoreChange> changes;
    changes.reserve(records.size() + 1);
    changes.emplace_back(store::ForgetRecords{account});
    for (store::PutRecord& record : records) {
        changes.emplace_back(std::move(record));
    }
    service_->submit(std::move(changes), std::move(done));
}

void ServerStore::change(store::StoreChange change, std::function<void(const std::string&)> done) {
    if (!service_) {
        done("store.kind is STORE_NONE");
        return;
    }
    // Where the store fails already, nobody waits for it: the change is made when it works again.
    const std::string failing = service_->figures().failing;
    std::vector<store::StoreChange> changes;
    changes.push_back(std::move(change));
    if (!failing.empty()) {
        service_->submit(std::move(changes), {});
        done(failing);
        return;
    }
    service_->submit(std::move(changes), [done = std::move(done)](bool stored) {
        done(stored ? "" : "the store takes no more at the moment");
    });
}

std::optional<store::StoreFigures> ServerStore::figures() const {
    return service_ ? std::optional(service_->figures()) : std::nullopt;
}

}  // namespace zoned::app
