#include "server/app/cluster/server_cluster.h"

#include "server/app/log/log.h"
#include "server/app/runtime/tick_loop.h"
#include "server/session/session_settings.h"
#include "shared/core/hex.h"

#include <asio/io_context.hpp>
#include <asio/signal_set.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <stdexcept>
#include <utility>

namespace zoned::app {

using cluster::AccountClaim;
using cluster::LeaseState;
using cluster::SettledWrite;

namespace {

constexpr double kLookEvery_s = 1.0;
/// All worlds are listed at one look in so many.
constexpr int kListEvery = 5;
/// A login asks the board so often before it is refused.
constexpr int kLoginAttempts = 8;
constexpr double kAskAgain_s = 0.1;
constexpr double kWriteAgain_s = 0.1;
/// While a character of the account is on its way from here, or its records on their way into the
/// store, a login waits.
constexpr double kWaitForTravel_s = 0.02;
constexpr std::int64_t kTicketValid_s = 120;
constexpr std::int64_t kClocksDiffer_s = 60;

/// A wait during the start, when the server's own loop does not hear signals yet.
class StartPause {
  public:
    StartPause() {
        signals_.async_wait([this](const asio::error_code& error, int) { asked_ = !error; });
    }

    /// Throws std::runtime_error when the process is asked to stop.
    void wait(double seconds) {
        io_.run_for(std::chrono::duration_cast<std::chrono::nanoseconds>(
            std::chrono::duration<double>(seconds)));
        if (asked_) {
            throw std::runtime_error(
                "asked to stop while the world waited for the board; what is kept of it stays");
        }
    }

  private:
    asio::io_context io_;
    asio::signal_set signals_{io_, SIGINT, SIGTERM};
    bool asked_ = false;
};

std::int64_t unix_now_s() {
    using namespace std::chrono;
    return duration_cast<seconds>(system_clock::now().time_since_epoch()).count();
}

std::vector<store::PutRecord> records_of(const proto::cluster::AccountEntry& entry) {
    std::vector<store::PutRecord> out;
    for (const proto::cluster::Record& record : entry.records()) {
        const bool of_character =
            record.scope() == static_cast<std::uint32_t>(store::StoreScope::kCharacter);
        out.push_back({{of_character ? store::StoreScope::kCharacter : store::StoreScope::kAccount,
                        entry.account(),
                        of_character ? record.character() : std::string(),
                        record.key()},
                       {record.value().begin(), record.value().end()}});
    }
    return out;
}

}  // namespace

ServerCluster::ServerCluster(const config::Settings& settings,
                             ClusterSeat& seat,
                             ClusterPorts ports)
    : settings_(settings.server),
      seat_(seat),
      ports_(std::move(ports)),
      faults_(settings.server.testing.travel, seat.world()),
      accounts_(seat.board(), seat.world()) {
    ports_.host->trust_cluster(session::public_key_of(seat_.realm_key()));
}

ServerCluster::~ServerCluster() {
    stop();
    release();
}

std::set<std::string> ServerCluster::reclaim(const std::set<std::string>& accounts) {
    std::set<std::string> elsewhere;
    StartPause pause;
    bool logged = false;
    for (const std::string& account : accounts) {
        AccountClaim claim = accounts_.claim(account, seat_.lease().epoch(), true);
        while (claim.owner == AccountClaim::Owner::kAgain || !seat_.lease().valid()) {
            if (seat_.lease().state() == LeaseState::kLost) {
                throw std::runtime_error("another server has taken the world " + seat_.world());
            }
            if (!std::exchange(logged, true)) {
                log_of(LogArea::kCluster)
                    .warn("the world waits for the board to say who is still in it: {}",
                          claim.trouble);
            }
            pause.wait(kAskAgain_s);
            claim = accounts_.claim(account, seat_.lease().epoch(), true);
        }
        if (claim.owner == AccountClaim::Owner::kHere) {
            claim.entry.clear_arrival();
            claim.entry.clear_records();
            known_[account] = {claim.revision, std::move(claim.entry)};
            faults_.begins(account);
        } else {
            // It was given away; what it brings back, if it is on its way here, is newer.
            elsewhere.insert(account);
        }
    }
    if (!accounts.empty()) {
        log_of(LogArea::kCluster)
            .info("of {} accounts in the world as it was, {} are in another one by now",
                  accounts.size(),
                  elsewhere.size());
    }
    return elsewhere;
}

void ServerCluster::listen(const config::AdvertiseSettings& advertised,
                           std::uint16_t tcp_port,
                           const std::string& fingerprint,
                           std::function<proto::cluster::WorldLoad()> load) {
    messages_ = seat_.board().subscribe("world." + seat_.world(),
                                        [this](const std::string& bytes) { on_message(bytes); });
    for (const config::PortalSettings& portal : settings_.portals) {
        seat_.directory().know(portal.to_world);
    }
    directory_thread_.post([this] { look_at_directory(0); });
    seat_.listen(
        [&](proto::cluster::WorldEntry& entry) {
            entry.set_host(advertised.address);
            entry.set_tcp_port(advertised.tcp_port == 0 ? tcp_port : advertised.tcp_port);
            entry.set_protocol_version(session::HostSettings().protocol_version);
            if (const auto digest = core::from_hex(fingerprint)) {
                entry.set_certificate_sha256(digest->data(), digest->size());
            }
        },
        std::move(load),
        [this](LeaseState state) { ports_.on_network([this, state] { on_lease(state); }); });
}

void ServerCluster::stop() {
    messages_.reset();
    directory_thread_.stop();
    worker_.stop();
}

void ServerCluster::set_draining() {
    draining_ = true;
    seat_.set_draining();
}

void ServerCluster::on_lease(LeaseState state) {
    if (state == LeaseState::kLapsed) {
        lapses_.fetch_add(1);
        log_of(LogArea::kCluster)
            .error(
                "the lease of the world {} has ended: {}; players play on, nobody joins or "
                "travels",
                seat_.world(),
                seat_.lease().trouble());
        if (!draining_) {
            ports_.host->set_draining(
                "the server has lost touch with its cluster: try again later");
        }
    } else if (state == LeaseState::kHeld) {
        log_of(LogArea::kCluster).info("the lease of the world {} is renewed again", seat_.world());
        if (!draining_) {
            ports_.host->set_draining("");
        }
    } else if (state == LeaseState::kLost) {
        log_of(LogArea::kCluster)
            .error("another server has taken the world {} after the lease ended", seat_.world());
        ports_.stop_server("another server has the world now");
    }
}

void ServerCluster::on_message(const std::string& bytes) {
    proto::cluster::WorldMessage message;
    if (!message.ParseFromString(bytes)) {
        return;
    }
    if (message.has_drain()) {
        const double grace_s = std::clamp(message.drain().grace_s(), 0.0, 86400.0);
        ports_.on_network([this, grace_s] {
            log_of(LogArea::kCluster).info("the cluster asks this server to drain");
            ports_.drain(grace_s);
        });
    } else if (message.has_coming()) {
        worker_.post(
            [this, account = message.coming().account()] { ask(account, {}, {}, kLoginAttempts); });
    }
}

void ServerCluster::look_at_directory(int turn) {
    if (turn % kListEvery == 0) {
        static_cast<void>(seat_.directory().list(steady_seconds()));
    }
    const std::string trouble = seat_.directory().look(steady_seconds());
    if (!trouble.empty() && directory_trouble_.empty()) {
        log_of(LogArea::kCluster).warn("the board does not answer: {}; travel waits", trouble);
    } else if (trouble.empty() && !directory_trouble_.empty()) {
        log_of(LogArea::kCluster).info("the board answers again");
    }
    directory_trouble_ = trouble;
    directory_thread_.post([this, turn] { look_at_directory(turn + 1); }, kLookEvery_s);
}

std::optional<proto::Redirect> ServerCluster::redirect_to(
    const std::string& world,
    const session::Traveller* traveller) const {
    const auto found = seat_.directory().find(world, steady_seconds());
    if (!found || !found->open()) {
        return std::nullopt;
    }
    const proto::cluster::WorldEntry& entry = found->entry;
    if (entry.host().empty() && entry.machine() != seat_.machine()) {
        log_of(LogArea::kCluster)
            .error(
                "nobody can be sent to the world {}: it runs on another machine, and its "
                "network.advertise.address is not set",
                world);
        return std::nullopt;
    }
    proto::Redirect out;
    out.set_world(world);
    out.set_host(entry.host());
    out.set_tcp_port(entry.tcp_port());
    out.set_certificate_sha256(entry.certificate_sha256());
    if (traveller != nullptr) {
        session::TicketClaims claims;
        claims.account = traveller->account;
        claims.name = traveller->name;
        claims.team = traveller->team;
        claims.rights = traveller->rights;
        claims.not_before_s = unix_now_s() - kClocksDiffer_s;
        claims.expires_s = unix_now_s() + kTicketValid_s;
        claims.nonce = session::random_nonce();
        claims.world = world;
        const auto ticket = session::create_ticket(claims, seat_.realm_key());
        if (ticket.ok()) {
            out.set_ticket(ticket->data(), ticket->size());
        }
    }
    return out;
}

std::optional<proto::Redirect> ServerCluster::find_world(const std::string& world) const {
    return redirect_to(world, nullptr);
}

ServerCluster::Place ServerCluster::place_of(const std::string& arrival) const {
    const auto it = std::find_if(settings_.arrivals.begin(),
                                 settings_.arrivals.end(),
                                 [&](const auto& one) { return one.name == arrival; });
    return it == settings_.arrivals.end() ? Place() : Place(it->position_m);
}

void ServerCluster::admit(const session::LoginToStore& login, LetIn let_in) {
    const bool leaves = std::any_of(leaving_.begin(), leaving_.end(), [&](const auto& entry) {
        return entry.second.frozen && entry.second.who.account == login.account;
    });
    if (leaves) {
        worker_.post(
            [this, login, let_in] {
                ports_.on_network([this, login, let_in] {
                    if (ports_.host->waiting_login(login.stream)) {
                        admit(login, let_in);
                    }
                });
            },
            kWaitForTravel_s);
        return;
    }
    worker_.post([this, login, let_in] {
        ask(
            login.account,
            [this, account = login.account, let_in](const Place& place) {
                ports_.on_network([this, account, place, let_in] {
                    faults_.begins(account);
                    let_in(place);
                    faults_.at(config::TravelStep::kJoined);
                });
            },
            [this, stream = login.stream](const std::string& text, const std::string& world) {
                ports_.on_network(
                    [this, stream, text, world] { refuse_login(stream, text, world); });
            },
            0);
    });
}

void ServerCluster::refuse_login(session::StreamId stream,
                                 const std::string& text,
                                 const std::string& world) {
    const auto who = ports_.host->waiting_login(stream);
    if (!who) {
        return;
    }
    if (const auto redirect = world.empty() ? std::nullopt : redirect_to(world, &*who)) {
        redirects_.fetch_add(1);
        ports_.host->refuse_login(stream, text, &*redirect);
        return;
    }
    refused_.fetch_add(1);
    ports_.host->refuse_login(stream,
                              world.empty() ? text
                                            : text +
                                                  ", which no server has at the moment: try "
                                                  "again later",
                              nullptr);
}

/// Without `let_in` it is no login: somebody is said to come.
void ServerCluster::ask(const std::string& account, LetIn let_in, RefuseLogin refuse, int attempt) {
    if (!seat_.lease().valid()) {
        if (refuse) {
            refuse("the server has lost touch with its cluster: try again later", "");
        }
        return;
    }
    if (unpacking_.count(account) != 0) {
        if (let_in) {
            worker_.post(
                [this, account, let_in, refuse, attempt] { ask(account, let_in, refuse, attempt); },
                kWaitForTravel_s);
        }
        return;
    }
    const auto login = static_cast<bool>(let_in);
    AccountClaim claim = accounts_.claim(account, seat_.lease().epoch(), login);
    switch (claim.owner) {
        case AccountClaim::Owner::kHere:
            if (login) {
                settle(account, claim.revision, {claim.revision, claim.entry}, let_in);
            }
            return;
        case AccountClaim::Owner::kArriving:
            unpack(claim, std::move(let_in), std::move(refuse));
            return;
        case AccountClaim::Owner::kElsewhere:
            known_.erase(account);
            if (refuse) {
                refuse("the account is in the world " + claim.entry.world(), claim.entry.world());
            }
            return;
        case AccountClaim::Owner::kAgain:
            break;
    }
    if (attempt + 1 < kLoginAttempts) {
        worker_.post(
            [this, account, let_in, refuse, attempt] { ask(account, let_in, refuse, attempt + 1); },
            kAskAgain_s);
    } else if (refuse) {
        refuse("the cluster does not say where the account is (" + claim.trouble +
                   "): try again later",
               "");
    }
}

void ServerCluster::unpack(const AccountClaim& claim, LetIn let_in, RefuseLogin refuse) {
    faults_.at(config::TravelStep::kHeard);
    unpacking_.insert(claim.entry.account());
    put_into_store(std::make_shared<AccountClaim>(claim), std::move(let_in), std::move(refuse));
}

void ServerCluster::put_into_store(std::shared_ptr<AccountClaim> claim,
                                   LetIn let_in,
                                   RefuseLogin refuse) {
    std::vector<store::PutRecord> records = records_of(claim->entry);
    if (faults_.lose_records()) {
        records.clear();
    }
    ports_.store->replace_records(
        claim->entry.account(), std::move(records), [this, claim, let_in, refuse](bool stored) {
            worker_.post(
                [this, claim, let_in, refuse, stored] {
                    if (!stored) {
                        put_into_store(claim, let_in, refuse);
                        return;
                    }
                    faults_.at(config::TravelStep::kUnpacked);
                    accept(claim,
                           std::make_shared<SettledWrite>(accounts_.accept(
                               *claim, seat_.lease().epoch(), static_cast<bool>(let_in))),
                           let_in,
                           refuse);
                },
                stored ? 0.0 : kWriteAgain_s);
        });
}

void ServerCluster::accept(std::shared_ptr<AccountClaim> claim,
                           std::shared_ptr<SettledWrite> write,
                           LetIn let_in,
                           RefuseLogin refuse) {
    const std::string& account = claim->entry.account();
    const auto outcome =
        seat_.lease().valid() ? write->attempt(seat_.board()) : SettledWrite::Outcome::kAgain;
    if (outcome == SettledWrite::Outcome::kAgain) {
        worker_.post([this, claim, write, let_in, refuse] { accept(claim, write, let_in, refuse); },
                     kWriteAgain_s);
        return;
    }
    unpacking_.erase(account);
    if (outcome == SettledWrite::Outcome::kOvertaken) {
        ask(account, let_in, refuse, 0);
        return;
    }
    faults_.at(config::TravelStep::kAccepted);
    travels_in_.fetch_add(1);
    log_of(LogArea::kCluster)
        .info("account {} came from the world {}", account, claim->entry.from_world());
    if (let_in) {
        proto::cluster::AccountEntry entry = claim->entry;
        entry.set_state(proto::cluster::ACCOUNT_HERE);
        settle(account, write->revision, {write->revision, std::move(entry)}, let_in);
    }
}

void ServerCluster::settle(const std::string& account,
                           std::uint64_t revision,
                           Known known,
                           const LetIn& let_in) {
    const Place place = place_of(known.entry.arrival());
    known.revision = revision;
    known.entry.clear_arrival();
    known.entry.clear_records();
    known_[account] = std::move(known);
    let_in(place);
}

ClusterFigures ServerCluster::figures() const {
    ClusterFigures out;
    out.held = seat_.lease().valid();
    out.connected = seat_.board().connected();
    out.lease_left_s = seat_.lease().left_s();
    out.epoch = seat_.lease().epoch();
    out.lapses = lapses_.load();
    out.travels_out = travels_out_.load();
    out.travels_in = travels_in_.load();
    out.travelling = travelling_.load();
    out.redirects = redirects_.load();
    out.refused = refused_.load();
    return out;
}

}  // namespace zoned::app
