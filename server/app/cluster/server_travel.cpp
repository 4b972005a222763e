// The way of an account from this world to another.
#include "server/app/cluster/server_cluster.h"
#include "server/app/log/log.h"
#include "server/app/runtime/tick_loop.h"

#include <utility>

namespace zoned::app {

using cluster::SettledWrite;

namespace {

/// A client hears so often that a portal is closed.
constexpr double kNotifyEvery_s = 10.0;
constexpr double kGiveAgain_s = 0.2;
constexpr double kReadAgain_s = 0.5;
constexpr double kLeavePatience_s = 5.0;
/// NATS servers take messages of 1 MB where their operator says nothing else.
constexpr std::size_t kMostBytes = 900'000;

std::size_t size_of(const std::vector<store::PutRecord>& records) {
    std::size_t bytes = 0;
    for (const store::PutRecord& record : records) {
        bytes += record.key.character.size() + record.key.key.size() + record.value.size() + 16;
    }
    return bytes;
}

}  // namespace

void ServerCluster::on_tick(std::span<const TravelWish> wishes,
                            std::span<const TravelAhead> ahead,
                            std::span<const ClientId> departed) {
    for (const ClientId client : departed) {
        notified_s_.erase(client);
        if (const auto it = leaving_.find(client); it != leaving_.end()) {
            left(client, it->second);
        }
    }
    for (auto& [client, leaving] : leaving_) {
        // A zone that has stopped lets nobody go, and has nobody any more.
        if (leaving.frozen && steady_seconds() - leaving.frozen_s > kLeavePatience_s) {
            left(client, leaving);
        }
    }
    for (const TravelAhead& one : ahead) {
        if (const auto redirect = redirect_to(one.world, nullptr)) {
            ports_.host->announce(one.client, *redirect);
        }
    }
    for (const TravelWish& one : wishes) {
        wish(one);
    }
}

void ServerCluster::left(ClientId client, Leaving& leaving) {
    if (leaving.frozen && !leaving.left) {
        leaving.left = true;
        faults_.ends(leaving.who.account);
        faults_.at(config::TravelStep::kFrozen);
        read_records(client);
    }
}

void ServerCluster::wish(const TravelWish& wish) {
    const auto who = ports_.host->traveller(wish.client);
    if (!who || leaving_.count(wish.client) != 0) {
        return;
    }
    if (who->account.empty()) {
        turn_back(wish.client, "only players with an account can go to another world");
        return;
    }
    if (!seat_.lease().valid() || !redirect_to(wish.world, nullptr)) {
        turn_back(wish.client, "the way to the world " + wish.world + " is closed");
        return;
    }
    faults_.at(config::TravelStep::kWished);
    Leaving& leaving = leaving_[wish.client];
    leaving.who = *who;
    leaving.to = wish.world;
    leaving.arrival = wish.arrival;
    worker_.post([this, client = wish.client, account = who->account] { probe(client, account); });
}

void ServerCluster::turn_back(ClientId client, const std::string& text) {
    const double now_s = steady_seconds();
    const auto [it, first] = notified_s_.try_emplace(client, now_s);
    if (first || now_s - it->second > kNotifyEvery_s) {
        it->second = now_s;
        refused_.fetch_add(1);
        ports_.host->notify(client, text);
    }
}

/// On the worker's thread. Nothing has changed yet, and nothing does where the board takes no
/// writes: the client plays on, and wishes again.
void ServerCluster::probe(ClientId client, const std::string& account) {
    bool good = false;
    if (known_.count(account) != 0) {
        for (int i = 0; i < 2 && !good; ++i) {
            proto::cluster::Probe probe;
            probe.set_count(++probes_);
            SettledWrite write{
                "probe." + seat_.world(), probe_revision_, probe.SerializeAsString()};
            const auto outcome = write.attempt(seat_.board());
            good = outcome == SettledWrite::Outcome::kDone;
            if (outcome == SettledWrite::Outcome::kOvertaken) {
                probe_revision_ = write.present.revision;  // of a server before this one
            } else if (good) {
                probe_revision_ = write.revision;
            }
        }
    }
    ports_.on_network([this, client, good] {
        if (good) {
            faults_.at(config::TravelStep::kProbed);
            freeze(client);
        } else {
            leaving_.erase(client);
        }
    });
}

void ServerCluster::freeze(ClientId client) {
    const auto it = leaving_.find(client);
    if (it == leaving_.end()) {
        return;
    }
    if (!seat_.lease().valid() || !ports_.host->traveller(client)) {
        leaving_.erase(it);
        return;
    }
    Leaving& leaving = it->second;
    // The others leave first: what they write to the store is read with the rest.
    ports_.host->end_account(
        leaving.who.account, client, "a character of the account went to another world");
    ports_.host->begin_travel(client, faults_.keep_avatar());
    leaving.frozen = true;
    leaving.frozen_s = steady_seconds();
    travelling_.fetch_add(1);
    if (faults_.keep_avatar()) {
        leaving.left = true;
        read_records(client);
    }
}

void ServerCluster::read_records(ClientId client) {
    const Leaving leaving = leaving_.at(client);
    ports_.store->read_records(
        leaving.who.account,
        [this, client, leaving](std::optional<std::vector<store::PutRecord>> records) {
            if (!records) {
                worker_.post(
                    [this, client] {
                        ports_.on_network([this, client] {
                            if (leaving_.count(client) != 0) {
                                read_records(client);
                            }
                        });
                    },
                    kReadAgain_s);
                return;
            }
            ports_.on_network(
                [this,
                 client,
                 taken = std::make_shared<std::vector<store::PutRecord>>(std::move(*records))] {
                    if (leaving_.count(client) != 0) {
                        await_journal(client, taken);
                    }
                });
        });
}

/// Nothing given away may come back here after a crash: neither the avatar, nor a record that
/// was put before, on top of one from a later visit. The store settles first, so that the world has
/// been told of all that it did.
void ServerCluster::await_journal(ClientId client,
                                  std::shared_ptr<std::vector<store::PutRecord>> records) {
    ports_.when_kept([this, client, records] {
        const auto it = leaving_.find(client);
        if (it == leaving_.end()) {
            return;
        }
        worker_.post([this, client, leaving = it->second, records] {
            give(client, leaving, std::move(*records));
        });
    });
}

/// On the worker's thread, as all of the board's.
void ServerCluster::give(ClientId client,
                         const Leaving& leaving,
                         std::vector<store::PutRecord> records) {
    faults_.at(config::TravelStep::kPacked);
    const auto known = known_.find(leaving.who.account);
    if (known == known_.end() || size_of(records) > kMostBytes) {
        ports_.on_network([this, client] {
            give_up(client, "the account has too many records to travel, or is no longer here");
        });
        return;
    }
    std::vector<proto::cluster::Record> packed;
    for (store::PutRecord& record : records) {
        proto::cluster::Record& to = packed.emplace_back();
        to.set_scope(static_cast<std::uint32_t>(record.key.scope));
        to.set_character(std::move(record.key.character));
        to.set_key(std::move(record.key.key));
        to.set_value(record.value.data(), record.value.size());
    }
    give_again(client,
               leaving.who.account,
               leaving.to,
               std::make_shared<SettledWrite>(accounts_.give(known->second.entry,
                                                             known->second.revision,
                                                             seat_.lease().epoch(),
                                                             leaving.to,
                                                             leaving.arrival,
                                                             std::move(packed))));
}

/// The only point at which an account changes hands. Until its outcome is known the avatar stays
/// away, and the same write is tried again.
void ServerCluster::give_again(ClientId client,
                               const std::string& account,
                               const std::string& to,
                               std::shared_ptr<SettledWrite> write) {
    const auto outcome =
        seat_.lease().valid() ? write->attempt(seat_.board()) : SettledWrite::Outcome::kAgain;
    if (outcome == SettledWrite::Outcome::kAgain) {
        worker_.post([this, client, account, to, write] { give_again(client, account, to, write); },
                     kGiveAgain_s);
        return;
    }
    known_.erase(account);
    std::string world = to;
    if (outcome == SettledWrite::Outcome::kDone) {
        faults_.at(config::TravelStep::kCommitted);
        travels_out_.fetch_add(1);
        proto::cluster::WorldMessage message;
        message.mutable_coming()->set_account(account);
        seat_.board().publish("world." + to, message.SerializeAsString());
        faults_.at(config::TravelStep::kTold);
        log_of(LogArea::kCluster).info("account {} went to the world {}", account, to);
    } else {
        // A write whose answer was lost, and which the other world has taken up since; or a server
        // took this world while this one was cut off.
        proto::cluster::AccountEntry present;
        static_cast<void>(present.ParseFromString(write->present.value));
        world = present.world();
        log_of(LogArea::kCluster)
            .warn("account {} is in the world {} by the word of another server", account, world);
    }
    ports_.on_network([this, client, world] { gone(client, world); });
}

void ServerCluster::gone(ClientId client, const std::string& world) {
    const auto it = leaving_.find(client);
    if (it == leaving_.end()) {
        return;
    }
    const Leaving leaving = std::move(it->second);
    leaving_.erase(it);
    travelling_.fetch_sub(1);
    if (const auto redirect = redirect_to(world, &leaving.who)) {
        ports_.host->redirect(client, "the character is in the world " + world, *redirect);
    } else {
        ports_.host->kick({client, "", ""},
                          "the character is in the world " + world + ": log in there");
    }
    faults_.at(config::TravelStep::kRedirected);
}

void ServerCluster::give_up(ClientId client, const std::string& text) {
    leaving_.erase(client);
    travelling_.fetch_sub(1);
    log_of(LogArea::kCluster).error("a character could not travel: {}", text);
    ports_.host->kick({client, "", ""}, text);
}

}  // namespace zoned::app
