#include "tests/integration/cluster/realm.h"

#include "server/cluster/accounts.h"
#include "server/cluster/nats_board.h"
#include "server/store/sqlite_store.h"
#include "shared/core/hex.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

namespace zoned::testing_cluster {

namespace {

constexpr double kInputEvery_s = 0.1;
constexpr double kLoginEvery_s = 0.1;

std::string read(const std::string& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

link::Trust anyone() {
    link::Trust trust;
    trust.kind = link::Trust::TrustKind::kInsecure;
    return trust;
}

store::StoredBytes token_of(const std::string& account) {
    const std::string text = "the token of " + account;
    return {text.begin(), text.end()};
}

store::StoreKey token_key(const std::string& account) {
    return {store::StoreScope::kCharacter, account, account, "token"};
}

/// One line of the journal of testing.travel.
struct JournalLine {
    std::int64_t at_ns = 0;
    std::string what;
    std::string world;
    std::string account;
};

std::vector<JournalLine> read_journal(const std::string& path) {
    std::vector<JournalLine> out;
    std::ifstream file(path);
    JournalLine line;
    while (file >> line.at_ns >> line.what >> line.world >> line.account) {
        out.push_back(line);
    }
    return out;
}

}  // namespace

double now_s() {
    using Clock = std::chrono::steady_clock;
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

void Wanderer::enter(std::uint16_t port) {
    if (!closed() || now_s() < next_login_s_) {
        return;
    }
    if (client_) {
        travels += client_->stats().travels;
        recovered += client_->stats().recovered;
    }
    next_login_s_ = now_s() + kLoginEvery_s;
    joined_ = false;
    client_.reset();
    transport_.reset();
    network_ = std::make_unique<link::SocketNetwork>(
        link::NetworkSettings{"127.0.0.1", std::to_string(port), anyone(), "", 1});
    transport_ = network_->make_transport();
    link::Login login;
    login.name = account_;
    login.ticket = ticket_();
    client_ = std::make_unique<link::Client>(*transport_, *this, login);
    client_->start(now_s());
}

void Wanderer::advance() {
    if (plays() && gone_s_ >= 0.0) {
        gaps_s.push_back(now_s() - gone_s_);
        gone_s_ = -1.0;
    } else if (!plays() && gone_s_ < 0.0 && joins > 0) {
        gone_s_ = now_s();
    }
    if (closed()) {
        return;
    }
    network_->poll(now_s());
    client_->advance(now_s());
    if (now_s() >= next_input_s_) {
        next_input_s_ = now_s() + kInputEvery_s;
        client_->send_input({}, now_s());
    }
    network_->flush();
}

void Wanderer::quit() {
    if (client_) {
        client_->quit(now_s());
        network_->poll(now_s());
    }
}

void Realm::SetUp() {
    ASSERT_TRUE(test::NatsServer::installed()) << "install nats-server (config/packages.txt)";
    folder = testing_process::scratch_folder();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    nats = std::make_unique<test::NatsServer>();
    keys = session::generate_key_pair();
    std::ofstream(folder + "/login.pub") << core::to_hex(keys.public_key) << "\n";
    std::ofstream(folder + "/login.key") << core::to_hex(keys.private_key) << "\n";
}

void Realm::TearDown() {
    players.clear();
    castle.server.reset();
    meadow.server.reset();
}

/// Rules that send whoever has been there for ten ticks to another world.
std::string Realm::sends_on(const std::string& other) {
    return "function on_join(client) state.came[client] = now() end\n"
           "function on_leave(client, avatar) state.came[client] = nil despawn(avatar) end\n"
           "function on_start() state.came = {} end\n"
           "function on_tick()\n"
           "  for client, tick in pairs(state.came) do\n"
           "    if now() >= tick + 10 then\n"
           "      state.came[client] = now() + 20\n"
           "      print(travel(client, '" +
           other + "', 'gate'), travel(client + 1000, '" + other +
           "'))\n"
           "    end\n"
           "  end\n"
           "end\n";
}

void Realm::write_config(World& world, const std::string& other, const std::string& more) {
    world.config = folder + "/" + world.name + ".txtpb";
    world.state = folder + "/" + world.name + "-state";
    std::string text = read(ZONED_SOURCE_DIR "/config/minimal.txtpb");
    text.replace(text.find("name: \"minimal\""), 15, "name: \"" + world.name + "\"");
    std::ofstream out(world.config);
    out << text << "cluster { name: \"" << world.name << "\" " << cluster_lines << " }\n"
        << "arrival { name: \"gate\" x_m: 7 z_m: 7 }\n"
        << "testing { travel { journal: \"" << folder << "/journal\" } }\n"
        << more;
    if (by_rules) {
        std::ofstream(folder + "/" + world.name + ".lua") << sends_on(other);
        out << "script { file: \"" << world.name << ".lua\" avatar: \"player\" }\n";
    } else {
        out << "portal { name: \"way\" min_x_m: -49 min_z_m: -49 max_x_m: 49 max_z_m: 49 to_world: "
               "\""
            << other << "\" arrival: \"gate\" wait_s: " << portal_wait_s << " }\n";
    }
}

void Realm::start(World& world, const std::vector<std::string>& sets, bool wait) {
    if (world.config.empty()) {
        write_config(world, &world == &castle ? meadow.name : castle.name, "");
    }
    std::vector<std::string> arguments{
        "serve", "--config", world.config, "--cluster", board_urls()};
    const auto set = [&](const std::string& text) {
        arguments.insert(arguments.end(), {"--set", text});
    };
    set("session.state_folder=\"" + world.state + "\"");
    set("session.ticket_public_key_file=\"" + folder + "/login.pub\"");
    set("session.dev_mode_loopback=false");
    set("store.durability=DURABLE_PROCESS");
    set("network.tcp_port=" + std::to_string(world.port));
    set("recording.ring_s=0");
    if (recovers) {
        set("recovery.on=true");
        set("recovery.durability=DURABLE_PROCESS");
    }
    if (recorded) {
        set("recording.file=\"" + folder + "/" + world.name + ".zrec\"");
    }
    for (const std::string& text : sets) {
        set(text);
    }
    world.server = std::make_unique<Child>("zoned", arguments);
    if (wait) {
        wait_until_ready(world);
    }
}

std::string Realm::board_urls() const {
    std::string out = nats->url();
    for (const auto& one : more_nats) {
        out += "," + one->url();
    }
    return out;
}

void Realm::wait_until_ready(World& world) {
    ASSERT_TRUE(world.server->wait_for_output("ready ", kPatience)) << world.server->errors();
    world.port =
        static_cast<std::uint16_t>(testing_process::number_after(world.server->output(), "tcp="));
}

void Realm::stop(World& world) {
    world.server->signal(SIGTERM);
    EXPECT_EQ(world.server->wait(kPatience), 0) << world.server->errors();
}

std::string Realm::ticket(const std::string& account) {
    session::TicketClaims claims;
    claims.account = account;
    claims.name = account;
    claims.rights = 1;
    claims.not_before_s = std::time(nullptr) - 60;
    claims.expires_s = std::time(nullptr) + 3600;
    claims.nonce = session::random_nonce();
    const auto made = session::create_ticket(claims, keys.private_key);
    return made.ok() ? std::string(made->begin(), made->end()) : std::string();
}

Wanderer& Realm::add(const std::string& account) {
    players.push_back(
        std::make_unique<Wanderer>(account, [this, account] { return ticket(account); }));
    return *players.back();
}

bool Realm::play_until(const std::function<bool()>& done, double seconds) {
    const double end = now_s() + seconds;
    std::size_t turn = 0;
    while (!done()) {
        if (now_s() > end) {
            return false;
        }
        for (const auto& player : players) {
            if (player->closed()) {
                const World& world = (turn++ % 2 == 0) != (castle.port == 0) ? castle : meadow;
                if (world.port != 0) {
                    player->enter(world.port);
                }
            }
            player->advance();
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

void Realm::give_tokens(const World& world, const std::vector<std::string>& accounts) {
    std::filesystem::create_directories(world.state);
    const auto opened = store::open_sqlite_store(
        world.state + "/store.db", store::Durability::kProcess, store::StoreUse::kServe);
    ASSERT_TRUE(opened.ok()) << opened.error().text;
    std::vector<store::StoreChange> changes;
    for (const std::string& account : accounts) {
        changes.emplace_back(store::PutRecord{token_key(account), token_of(account)});
    }
    ASSERT_TRUE((*opened)->commit(changes).ok());
}

std::unique_ptr<cluster::Board> Realm::board() const {
    cluster::NatsSettings settings;
    settings.urls = {nats->url()};
    auto connected = cluster::connect_nats_board(settings);
    EXPECT_TRUE(connected.ok()) << connected.error();
    return connected.ok() ? std::move(*connected) : nullptr;
}

std::vector<TravelFinding> Realm::findings() {
    using Wrong = TravelFinding::Wrong;
    std::vector<TravelFinding> out;
    // Two owners: one begins to have an account that another one has not let go.
    std::map<std::string, std::string> holder;
    std::vector<JournalLine> lines = read_journal(folder + "/journal");
    std::stable_sort(
        lines.begin(), lines.end(), [](const auto& x, const auto& y) { return x.at_ns < y.at_ns; });
    for (const JournalLine& line : lines) {
        std::string& held = holder[line.account];
        if (!held.empty() && held != line.world) {
            out.push_back({Wrong::kTwoOwners,
                           line.account + " is in two worlds: " + held + " has it, and " +
                               line.world + " writes " + line.what});
        }
        held = line.what == "begin" ? line.world : "";
    }
    const auto asked = board();
    std::map<std::string, std::unique_ptr<store::Store>> stores;
    for (const World* world : {&castle, &meadow}) {
        auto opened = store::open_sqlite_store(
            world->state + "/store.db", store::Durability::kProcess, store::StoreUse::kInspect);
        if (!asked || !opened.ok()) {
            out.push_back({Wrong::kUnknown, "the board or the store of " + world->name});
            return out;
        }
        stores[world->name] = std::move(*opened);
    }
    for (const auto& player : players) {
        const std::string& account = player->account();
        const auto found = asked->get(cluster::Accounts::key_of(account));
        proto::cluster::AccountEntry entry;
        if (!found.ok() || !*found || !entry.ParseFromString((*found)->value)) {
            out.push_back({Wrong::kLost, account + " is nowhere"});
            continue;
        }
        // The owner has the token, and has it once.
        std::vector<store::StoredBytes> tokens;
        if (entry.state() == proto::cluster::ACCOUNT_ON_ITS_WAY) {
            for (const auto& record : entry.records()) {
                if (record.key() == "token") {
                    tokens.emplace_back(record.value().begin(), record.value().end());
                }
            }
        } else if (const auto value = stores[entry.world()]->get(token_key(account));
                   value.ok() && *value) {
            tokens.push_back(**value);
        }
        const auto good = std::count(tokens.begin(), tokens.end(), token_of(account));
        if (good != 1 || tokens.size() != 1) {
            out.push_back({good == 0 ? Wrong::kLost : Wrong::kDoubled,
                           account + " has " + std::to_string(tokens.size()) + " tokens, " +
                               std::to_string(good) + " of them its own, in the world " +
                               entry.world()});
        }
    }
    return out;
}

std::uint64_t Realm::travels() const {
    std::uint64_t sum = 0;
    for (const auto& player : players) {
        sum += player->total(&link::SessionStats::travels, player->travels);
    }
    return sum;
}

std::uint64_t Realm::recovered() const {
    std::uint64_t sum = 0;
    for (const auto& player : players) {
        sum += player->total(&link::SessionStats::recovered, player->recovered);
    }
    return sum;
}

void Realm::expect_clean() {
    for (const TravelFinding& finding : findings()) {
        ADD_FAILURE() << finding.text;
    }
}

void Realm::begin(int count, const std::vector<std::string>& sets) {
    write_config(castle, "meadow", "");
    write_config(meadow, "castle", "");
    if (recovers) {
        // A world comes back under its very config, and the port is part of that.
        castle.port = test::free_port();
        meadow.port = test::free_port();
    }
    std::vector<std::string> accounts;
    for (int i = 0; i < count; ++i) {
        accounts.push_back("player" + std::to_string(i));
        add(accounts.back());
    }
    give_tokens(castle, accounts);
    start(castle, sets, false);
    start(meadow, sets, false);
    wait_until_ready(castle);
    wait_until_ready(meadow);
}

bool Realm::all_play() const {
    return std::all_of(players.begin(), players.end(), [](const auto& p) { return p->plays(); });
}

void Realm::enter_the_castle() {
    const std::uint16_t port = meadow.port;
    meadow.port = 0;
    ASSERT_TRUE(play_until(
        [&] {
            return std::all_of(
                players.begin(), players.end(), [](const auto& p) { return p->joins > 0; });
        },
        kPatience))
        << castle.server->errors();
    meadow.port = port;
}

void Realm::settle() {
    EXPECT_TRUE(play_until([&] { return all_play(); }, kPatience));
}

void Realm::end() {
    for (const auto& player : players) {
        player->quit();
    }
    stop(castle);
    stop(meadow);
}

int Realm::zoned(const std::vector<std::string>& arguments) {
    Child child("zoned", arguments);
    const int code = child.wait(kPatience);
    said = child.output();
    complained = child.errors();
    return code;
}

}  // namespace zoned::testing_cluster
