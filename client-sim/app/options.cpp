#include "client-sim/app/options.h"

#include "client-sim/app/tickets.h"
#include "shared/core/hex.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <map>
#include <stdexcept>

namespace zoned::app {

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  client-sim --connect 127.0.0.1:7777 --bots 200 --seconds 30 --report report.json\n"
    "  client-sim --connect game.example.org:7777 --bots 500 --seconds 60 --ticket tickets/\n"
    "  client-sim --connect [::1]:7777 --bots 50 --seconds 30 --behaviour border:2,chat\n"
    "             --loss 5 --delay-ms 60 --jitter-ms 20 --duplicate 2 --reorder 5\n"
    "Exit codes: 0 consistent, 1 inconsistent, 2 bad usage, 3 environment (no such host, bots too "
    "late to judge, ...).";

/// The command line before its checks.
struct Raw {
    std::string connect;
    std::string script;
    std::string convergence = "projective";
    std::string view = "extrapolate";
    std::string predictor = "published";
    std::string transport = "udp";
    std::string outage;
    std::string pin;
    std::vector<std::string> tickets;
    double loss = 0.0;
    double delay_ms = 0.0;
    double jitter_ms = 0.0;
    double duplicate = 0.0;
    double reorder = 0.0;
    double bottleneck_kbit_s = 0.0;
    double bottleneck_up_kbit_s = 0.0;
    double bottleneck_queue_ms = 250.0;
    bool no_audit = false;
    bool no_freeze = false;
};

void declare(CLI::App& app, Raw& raw, Options& o) {
    app.add_option("--connect", raw.connect, "HOST:PORT of the server (TCP)")->required();
    app.add_option("--bots", o.swarm.bots, "Number of bots")->check(CLI::Range(1, 100000));
    app.add_option("--seconds", o.swarm.seconds, "Length of the run after all bots were started")
        ->check(CLI::Range(0.1, 1e6));
    app.add_option("--behaviour", raw.script, "Mix NAME[:share],... of " + bot::script_names());
    app.add_option("--loss", raw.loss, "Lost datagrams, percent, each direction")
        ->check(CLI::Range(0.0, 100.0));
    app.add_option("--delay-ms", raw.delay_ms, "One-way delay per direction; TCP alike")
        ->check(CLI::Range(0.0, 10000.0));
    app.add_option("--jitter-ms", raw.jitter_ms, "Delay varies by as much in both directions")
        ->check(CLI::Range(0.0, 10000.0));
    app.add_option("--duplicate", raw.duplicate, "Doubled datagrams, percent")
        ->check(CLI::Range(0.0, 100.0));
    app.add_option("--reorder", raw.reorder, "Datagrams held back by one to two ticks, percent")
        ->check(CLI::Range(0.0, 100.0));
    app.add_option("--outage", raw.outage, "EVERY:LENGTH in seconds: the path is cut so long");
    app.add_option("--bottleneck-kbit-s",
                   raw.bottleneck_kbit_s,
                   "Each bot's path carries so much towards it, headers counted; 0: any amount")
        ->check(CLI::Range(0.0, 1e7));
    app.add_option(
           "--bottleneck-up-kbit-s", raw.bottleneck_up_kbit_s, "Likewise towards the server")
        ->check(CLI::Range(0.0, 1e7));
    app.add_option("--bottleneck-queue-ms",
                   raw.bottleneck_queue_ms,
                   "Datagrams that would wait for longer in a bottleneck are dropped")
        ->check(CLI::Range(0.0, 60000.0));
    app.add_option("--ramp-per-s", o.swarm.ramp_per_s, "Bots started per second")
        ->check(CLI::Range(0.1, 100000.0));
    app.add_option("--seed", o.swarm.seed, "Seed of scripts and of the link conditioner");
    app.add_option("--report", o.report_file, "Writes the report as JSON to FILE");
    app.add_option("--convergence", raw.convergence, "snap, linear, projective or hermite")
        ->check(CLI::IsMember({"snap", "linear", "projective", "hermite"}));
    app.add_option("--view",
                   raw.view,
                   "extrapolate (to the server's present) or interpolate (as far behind as news is "
                   "late)")
        ->check(CLI::IsMember({"extrapolate", "interpolate"}));
    // All clients share the server's encodings, so the server chooses the kind of prediction
    // (replication.predictor); a client can only refrain from it.
    app.add_option("--predictor",
                   raw.predictor,
                   "published (the kind that each publication names) or none (what was published "
                   "last stands still)")
        ->check(CLI::IsMember({"published", "none"}));
    app.add_option("--ticket",
                   raw.tickets,
                   "Ticket file, or a directory of them; one ticket per bot (repeatable)");
    app.add_option("--world",
                   o.swarm.world,
                   "Name of the world of a cluster: a server that has another one sends the bots "
                   "to the right one, at most 4 times in a row");
    app.add_option("--config-digest", o.swarm.config_digest, "Refuse a server of another config");
    app.add_option("--pin", raw.pin, "SHA-256 of the server's certificate, 64 hex digits");
    app.add_flag(
        "--insecure-dev", o.insecure_dev, "Trust any certificate (default for loopback addresses)");
    app.add_option("--ca", o.ca_file, "File of certificate authorities to verify against")
        ->check(CLI::ExistingFile);
    app.add_option("--audit-every-s", o.swarm.audit_every_s, "Seconds between a bot's audits")
        ->check(CLI::Range(0.05, 3600.0));
    app.add_flag("--no-audit", raw.no_audit, "Do not compare with the server's truth");
    app.add_flag("--no-freeze", raw.no_freeze, "Do not freeze the world at the end");
    app.add_option("--transport",
                   raw.transport,
                   "udp (states by UDP, the rest by TLS) or websocket (all as a browser does it: "
                   "--connect names the server's websocket= port; without TLS on loopback)")
        ->check(CLI::IsMember({"udp", "websocket"}));
    app.add_option("--udp-sockets", o.udp_sockets, "UDP sockets shared by the bots")
        ->check(CLI::Range(1, 1024));
    app.add_flag("--quiet", o.quiet, "No progress line");
    app.footer(kExamples);
}

void split_host(const std::string& text, Options& o) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == text.size()) {
        throw std::invalid_argument("--connect wants HOST:PORT, not '" + text + "'");
    }
    o.host = text.substr(0, colon);
    o.port = text.substr(colon + 1);
    if (o.host.size() > 2 && o.host.front() == '[' && o.host.back() == ']') {
        o.host = o.host.substr(1, o.host.size() - 2);
    }
    char* end = nullptr;
    const long port = std::strtol(o.port.c_str(), &end, 10);
    if (*end != '\0' || port < 1 || port > 65535) {
        throw std::invalid_argument("--connect: port '" + o.port + "' is not in 1..65535");
    }
}

std::vector<std::uint8_t> read_pin(const std::string& text) {
    auto pin = core::from_hex(text);
    if (!pin || (!pin->empty() && pin->size() != 32)) {
        throw std::invalid_argument("--pin wants 64 hex digits (SHA-256 of the certificate)");
    }
    return std::move(*pin);
}

void read_outage(const std::string& text, link::ConditionerSettings& c) {
    if (text.empty()) {
        return;
    }
    char rest = 0;
    if (std::sscanf(text.c_str(), "%lf:%lf%c", &c.outage_every_s, &c.outage_length_s, &rest) != 2 ||
        !(c.outage_every_s > 0.0) || !(c.outage_length_s > 0.0) ||
        c.outage_length_s >= c.outage_every_s) {
        throw std::invalid_argument(
            "--outage wants EVERY:LENGTH in seconds, LENGTH < EVERY, not '" + text + "'");
    }
}

void convert(const Raw& raw, Options& o) {
    split_host(raw.connect, o);
    if (!raw.script.empty()) {
        auto mix = bot::parse_mix(raw.script);
        if (!mix) {
            throw std::invalid_argument("--behaviour: " + mix.error());
        }
        o.swarm.mix = *mix;
    }
    const std::map<std::string, motion::ConvergenceMethod> methods = {
        {"snap", motion::ConvergenceMethod::kSnap},
        {"linear", motion::ConvergenceMethod::kLinear},
        {"projective", motion::ConvergenceMethod::kProjectiveVelocity},
        {"hermite", motion::ConvergenceMethod::kHermite}};
    o.swarm.convergence = methods.at(raw.convergence);
    o.swarm.view =
        raw.view == "interpolate" ? view::ViewKind::kInterpolate : view::ViewKind::kExtrapolate;
    o.swarm.displayed_state = raw.predictor == "none" ? view::DisplayedState::kPublished
                                                      : view::DisplayedState::kPredicted;
    if (raw.view == "interpolate" && raw.predictor == "none") {
        throw std::invalid_argument(
            "--predictor none is of --view extrapolate: an interpolating view needs what "
            "publications predict");
    }
    o.conditioner.loss = raw.loss / 100.0;
    o.conditioner.delay_s = raw.delay_ms / 1000.0;
    o.conditioner.jitter_s = raw.jitter_ms / 1000.0;
    o.conditioner.duplicate = raw.duplicate / 100.0;
    o.conditioner.reorder = raw.reorder / 100.0;
    o.conditioner.bottleneck_down_bytes_per_s = 125.0 * raw.bottleneck_kbit_s;
    o.conditioner.bottleneck_up_bytes_per_s = 125.0 * raw.bottleneck_up_kbit_s;
    o.conditioner.bottleneck_queue_s = raw.bottleneck_queue_ms / 1000.0;
    o.conditioner.seed = o.swarm.seed;
    read_outage(raw.outage, o.conditioner);
    o.pin = read_pin(raw.pin);
    o.websocket = raw.transport == "websocket";
    o.swarm.meter = !o.report_file.empty();
    o.swarm.audit = !raw.no_audit;
    o.swarm.freeze = !raw.no_freeze;
    o.swarm.tickets = read_tickets(raw.tickets);
    if (!o.swarm.tickets.empty() && o.swarm.tickets.size() < o.swarm.bots) {
        throw std::invalid_argument("--ticket: " + std::to_string(o.swarm.tickets.size()) +
                                    " tickets for " + std::to_string(o.swarm.bots) +
                                    " bots; a ticket opens one session only");
    }
}

}  // namespace

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
    Options options;
    Raw raw;
    CLI::App app("client-sim: bots that play on a zoned server and judge its consistency");
    declare(app, raw, options);
    try {
        app.parse(argc, argv);
        convert(raw, options);
    } catch (const CLI::ParseError& error) {
        exit_code = app.exit(error) == 0 ? kGood : kBadUsage;
        return std::nullopt;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "client-sim: %s\n", error.what());
        exit_code = kBadUsage;
        return std::nullopt;
    }
    return options;
}

}  // namespace zoned::app
