// zoned cluster: the servers of a realm under an operator's hands.
#include "server/app/cluster/cluster_seat.h"
#include "server/app/commands/commands.h"
#include "server/app/runtime/tick_loop.h"
#include "server/cluster/cluster_url.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

namespace zoned::app {

namespace {

constexpr double kAnswerPatience_s = 10.0;
/// NATS servers that choose a leader may not answer at once.
constexpr int kListAttempts = 5;
constexpr auto kLookAgain = std::chrono::milliseconds(100);

using Worlds = std::vector<cluster::ListedWorld>;

std::int64_t unix_ms() {
    using namespace std::chrono;
    return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

/// By what the entry says of itself; clocks of machines may differ a little.
double age_s(const proto::cluster::WorldEntry& entry) {
    return std::max(0.0, 1e-3 * static_cast<double>(unix_ms() - entry.written_unix_ms()));
}

const char* state_of(const proto::cluster::WorldEntry& entry) {
    if (entry.instance().empty()) {
        return "free";
    }
    if (age_s(entry) > 1e-3 * entry.lease_ms()) {
        return "lapsed";
    }
    if (entry.draining()) {
        return "draining";
    }
    return entry.tcp_port() == 0 ? "starting" : "open";
}

std::string place_of(const proto::cluster::WorldEntry& entry) {
    if (entry.tcp_port() == 0) {
        return "-";
    }
    return (entry.host().empty() ? entry.machine() : entry.host()) + ":" +
           std::to_string(entry.tcp_port());
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            out += '\\';
        }
        out += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    }
    return out + "\"";
}

void print_json(const Worlds& worlds) {
    std::printf("[");
    for (std::size_t i = 0; i < worlds.size(); ++i) {
        const proto::cluster::WorldEntry& e = worlds[i].entry;
        std::printf(
            "%s\n  {\"world\": %s, \"state\": \"%s\", \"address\": %s, \"machine\": %s, "
            "\"epoch\": %llu, \"age_s\": %.3f, \"lease_s\": %.3f, \"sessions\": %u, "
            "\"entities\": %u, \"tick_ms_p99\": %.3f, \"config_digest\": %s}",
            i == 0 ? "" : ",",
            quoted(e.world()).c_str(),
            state_of(e),
            quoted(place_of(e)).c_str(),
            quoted(e.machine()).c_str(),
            static_cast<unsigned long long>(e.epoch() == 0 ? worlds[i].revision : e.epoch()),
            age_s(e),
            1e-3 * e.lease_ms(),
            e.load().sessions(),
            e.load().entities(),
            e.load().tick_ms_p99(),
            quoted(e.config_digest()).c_str());
    }
    std::printf("%s]\n", worlds.empty() ? "" : "\n");
}

void print_table(const Worlds& worlds) {
    std::printf("%-16s %-9s %-24s %8s %8s %9s %9s %9s\n",
                "world",
                "state",
                "address",
                "epoch",
                "age s",
                "sessions",
                "entities",
                "p99 ms");
    for (const cluster::ListedWorld& world : worlds) {
        const proto::cluster::WorldEntry& e = world.entry;
        std::printf("%-16s %-9s %-24s %8llu %8.1f %9u %9u %9.2f\n",
                    e.world().c_str(),
                    state_of(e),
                    place_of(e).c_str(),
                    static_cast<unsigned long long>(e.epoch() == 0 ? world.revision : e.epoch()),
                    age_s(e),
                    e.load().sessions(),
                    e.load().entities(),
                    e.load().tick_ms_p99());
    }
}

int say_why(const std::string& text, int code) {
    std::fprintf(stderr, "zoned: %s\n", text.c_str());
    return code;
}

/// The board, or an exit code.
core::Result<std::unique_ptr<cluster::Board>, int> board_of(const ClusterArguments& arguments) {
    using Out = core::Result<std::unique_ptr<cluster::Board>, int>;
    if (arguments.urls.empty()) {
        return Out::failure(say_why("--cluster nats://HOST:PORT is missing", kUsage));
    }
    const auto parsed = cluster::parse_cluster_urls(arguments.urls);
    if (!parsed.ok()) {
        return Out::failure(say_why(parsed.error(), kUsage));
    }
    try {
        return open_board(arguments.urls, arguments.realm, "zoned cluster", 1);
    } catch (const std::exception& error) {
        return Out::failure(say_why(error.what(), kEnvironment));
    }
}

}  // namespace

int cluster_status(const ClusterArguments& arguments) {
    const auto board = board_of(arguments);
    if (!board.ok()) {
        return board.error();
    }
    cluster::Directory directory(**board);
    std::string trouble = directory.list(steady_seconds());
    for (int i = 1; i < kListAttempts && !trouble.empty(); ++i) {
        trouble = directory.list(steady_seconds());
    }
    if (!trouble.empty()) {
        return say_why(trouble, kEnvironment);
    }
    const Worlds worlds = directory.all(steady_seconds());
    if (arguments.json) {
        print_json(worlds);
    } else {
        print_table(worlds);
    }
    return kGood;
}

int cluster_drain(const ClusterArguments& arguments) {
    const auto board = board_of(arguments);
    if (!board.ok()) {
        return board.error();
    }
    cluster::Directory directory(**board);
    const double begun_s = steady_seconds();
    bool asked = false;
    directory.know(arguments.world);
    while (steady_seconds() - begun_s < kAnswerPatience_s) {
        const std::string trouble = directory.look(steady_seconds());
        const auto found = directory.find(arguments.world, steady_seconds());
        if (!asked && trouble.empty() && (!found || found->entry.instance().empty())) {
            return say_why("no server has the world " + arguments.world, kFailed);
        }
        if (asked && found && (found->entry.draining() || found->entry.instance().empty())) {
            if (arguments.json) {
                std::printf("{\"world\": %s, \"draining\": true}\n",
                            quoted(arguments.world).c_str());
            } else {
                std::printf(
                    "the server of %s drains: it ends when its last player has left, or "
                    "after %.0f s\n",
                    arguments.world.c_str(),
                    arguments.grace_s);
            }
            return kGood;
        }
        if (!asked) {
            proto::cluster::WorldMessage message;
            message.mutable_drain()->set_grace_s(arguments.grace_s);
            (*board)->publish("world." + arguments.world, message.SerializeAsString());
            asked = true;
        }
        std::this_thread::sleep_for(kLookAgain);
    }
    return say_why("the server of " + arguments.world + " does not answer", kFailed);
}

void add_cluster(CLI::App& app, ClusterArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand("cluster", "Look at the servers of a cluster, drain one");
    c->require_subcommand(1);
    const auto add_place = [&a](CLI::App& command) {
        command
            .add_option("--cluster",
                        a.urls,
                        "NATS servers, nats://HOST:PORT or tls://HOST:PORT, with commas between "
                        "(environment: ZONED_CLUSTER)")
            ->envname("ZONED_CLUSTER");
        command.add_option("--realm", a.realm, "The config's cluster.realm; default: zoned");
        command.add_flag("--json", a.json, "For programs");
    };
    CLI::App* status = c->add_subcommand("status", "Print the worlds and who has them");
    add_place(*status);
    status->footer("Example:\n  zoned cluster status --cluster nats://127.0.0.1:4222");
    status->callback([&] {
        run = [&a] {
            return cluster_status(a);
        };
    });
    CLI::App* drain =
        c->add_subcommand("drain", "No logins any more; the server ends when the last has left");
    drain->add_option("WORLD", a.world, "The config's cluster.name")->required();
    drain->add_option("--grace-s", a.grace_s, "It ends after this long in any case; default: 30")
        ->check(CLI::Range(0.0, 86400.0));
    add_place(*drain);
    drain->footer(
        "Whoever may speak to the NATS servers may do this: give them users or tokens.\n"
        "Example:\n  zoned cluster drain castle --cluster nats://127.0.0.1:4222");
    drain->callback([&] {
        run = [&a] {
            return cluster_drain(a);
        };
    });
}

}  // namespace zoned::app
