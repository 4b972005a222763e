#include "client-sim/app/run.h"

#include "client-sim/link/conditioned_network.h"
#include "client-sim/link/frame_stream.h"
#include "client-sim/link/sockets/name_lookup.h"
#include "client-sim/measure/loop_meter.h"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace zoned::app {

namespace {

/// Period at which the sockets are served; it bounds the delay that polling adds to measurements.
constexpr double kPeriodS = 0.001;

volatile std::sig_atomic_t stop_signal = 0;

void on_signal(int number) {
    stop_signal = number;
}

double wall_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

double process_cpu_s() {
    timespec t{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

link::NetworkSettings network_settings(const Options& o) {
    link::NetworkSettings n;
    n.host = o.host;
    n.port = o.port;
    n.ca_file = o.ca_file;
    n.udp_sockets = o.udp_sockets;
    if (o.websocket) {
        n.make_stream = link::make_websocket_stream;
    }
    if (!o.pin.empty()) {
        n.trust.kind = link::Trust::TrustKind::kPin;
        n.trust.pin = o.pin;
    } else if (o.insecure_dev || (link::is_loopback(o.host) && o.ca_file.empty())) {
        n.trust.kind = link::Trust::TrustKind::kInsecure;
    }
    return n;
}

void print_progress(const Swarm::Progress& p, bool terminal) {
    std::fprintf(stderr,
                 "%s%-8s started %zu online %zu joined %zu, %llu samples, %llu findings, %.0f s "
                 "left%s",
                 terminal ? "\r" : "",
                 p.phase,
                 p.started,
                 p.online,
                 p.joined,
                 static_cast<unsigned long long>(p.samples),
                 static_cast<unsigned long long>(p.findings),
                 p.seconds_left,
                 terminal ? "   " : "\n");
    std::fflush(stderr);
}

measure::LoopMeter drive(link::ConditionedNetwork& network, Swarm& swarm, bool quiet) {
    measure::LoopMeter meter;
    const bool terminal = ::isatty(STDERR_FILENO) == 1;
    const double begun = wall_s();
    double next_progress = 1.0;
    double next = 0.0;
    while (!swarm.done()) {
        const double now = wall_s() - begun;
        if (swarm.phase() == Swarm::RunPhase::kRun) {
            meter.turn(now);
        }
        network.poll(now);
        if (stop_signal != 0) {
            swarm.stop(now);
        }
        swarm.advance(now);
        network.flush();
        if (now >= next_progress) {
            next_progress += 1.0;
            if (!quiet) {
                print_progress(swarm.progress(now), terminal);
            }
        }
        next = std::max(next + kPeriodS, wall_s() - begun);
        std::this_thread::sleep_for(
            std::chrono::duration<double>(std::max(0.0, next - (wall_s() - begun))));
    }
    if (terminal && !quiet) {
        std::fputc('\n', stderr);
    }
    return meter;
}

void add_bottlenecks(const link::ConditionedNetwork& network, measure::RunReport& report) {
    double carried = 0.0;
    double capacity = 0.0;
    for (const link::BottleneckMeter& meter : network.bottlenecks(link::Direction::kDown)) {
        report.bottleneck = true;
        report.bottleneck_wait_s.merge(meter.wait_s);
        report.bottleneck_dropped += meter.dropped;
        carried += meter.carried_bytes;
        capacity += meter.capacity_bytes;
    }
    report.bottleneck_utilisation = capacity > 0.0 ? carried / capacity : 0.0;
}

std::string verdict_line(const measure::RunReport& report) {
    std::string line = std::string("verdict: ") + measure::verdict_of(report);
    std::vector<std::string> parts = report.reasons;
    if (!report.inconclusive.empty()) {
        parts.insert(parts.begin(), report.inconclusive);
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        line += (i > 0 ? "; " : ": ") + parts[i];
    }
    if (parts.empty() && !report.warnings.empty()) {
        line += ", with a warning: " + report.warnings.front();
    }
    return line;
}

bool write_report(const std::string& file, const measure::RunReport& report) {
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out << measure::to_json(report);
    out.flush();
    return static_cast<bool>(out);
}

}  // namespace

int run(const Options& options) {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    std::signal(SIGPIPE, SIG_IGN);
    // The report's file is tried before the run: a minute later is too late to learn of a typo.
    if (!options.report_file.empty() &&
        !std::ofstream(options.report_file, std::ios::binary | std::ios::app)) {
        std::fprintf(stderr,
                     "client-sim: cannot write %s; choose another --report FILE\n",
                     options.report_file.c_str());
        return kEnvironment;
    }
    try {
        link::ConditionedNetwork network(network_settings(options), options.conditioner);
        if (const std::string& why = network.sockets().trouble(); !why.empty()) {
            std::fprintf(stderr, "client-sim: %s\n", why.c_str());
            return kEnvironment;
        }
        SwarmSettings settings = options.swarm;
        settings.header_bytes = network.sockets().header_bytes();
        settings.path_spread_s = options.conditioner.spread_s();
        Swarm swarm(settings, [&](std::size_t) { return network.make_transport(); });
        const measure::LoopMeter loop = drive(network, swarm, options.quiet);
        measure::RunReport report = swarm.report();
        report.loop = loop;
        measure::judge(report);
        report.process_cpu_s = process_cpu_s();
        report.send_drops = network.sockets().send_drops();
        if (options.conditioner.bottleneck_down_bytes_per_s > 0.0) {
            add_bottlenecks(network, report);
        }
        if (!options.report_file.empty() && !write_report(options.report_file, report)) {
            std::fprintf(stderr, "client-sim: cannot write %s\n", options.report_file.c_str());
            return kEnvironment;
        }
        if (const std::string why = swarm.unreachable(); !why.empty()) {
            std::fprintf(stderr,
                         "client-sim: %s:%s: %s; is the server running and is the port its %s= "
                         "port?\n",
                         options.host.c_str(),
                         options.port.c_str(),
                         why.c_str(),
                         options.websocket ? "websocket" : "tcp");
            return kEnvironment;
        }
        std::fputs(measure::to_table(report).c_str(), stdout);
        const std::size_t around = static_cast<std::size_t>(options.swarm.header_bytes) +
                                   wire::kDatagramHeaderBytes + wire::kSealTagBytes +
                                   wire::kDownTransportBytes;
        std::fputs(wire::traffic_text(report.traffic, report.traffic_types, report.seconds, around)
                       .c_str(),
                   stdout);
        std::printf("%s\n", verdict_line(report).c_str());
        if (!report.inconclusive.empty()) {
            return kEnvironment;
        }
        return report.consistent ? kGood : kInconsistent;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "client-sim: %s\n", error.what());
        return kEnvironment;
    }
}

int client_main(int argc, char** argv, const bot::MakeOwnScript& make_own_script) {
    int exit_code = 0;
    auto options = parse_options(argc, argv, exit_code);
    if (!options) {
        return exit_code;
    }
    options->swarm.make_own_script = make_own_script;
    return run(*options);
}

}  // namespace zoned::app
