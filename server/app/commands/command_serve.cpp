#include "server/app/admin/admin_api.h"
#include "server/app/calibration/measure_codec.h"
#include "server/app/calibration/particle_device.h"
#include "server/app/cluster/cluster_wiring.h"
#include "server/app/commands/commands.h"
#include "server/app/commands/config_loading.h"
#include "server/app/commands/serve_report.h"
#include "server/app/log/crash_file.h"
#include "server/app/log/log.h"
#include "server/app/recovery/server_recovery.h"
#include "server/app/runtime/counter_watch.h"
#include "server/app/runtime/delivery_gate.h"
#include "server/app/runtime/host_settings.h"
#include "server/app/runtime/live_settings.h"
#include "server/app/runtime/network.h"
#include "server/app/runtime/recorder_settings.h"
#include "server/app/runtime/start_log.h"
#include "server/app/runtime/tick_loop.h"
#include "server/app/storage/server_store.h"
#include "server/app/supervision/supervision.h"
#include "server/app/world/world.h"
#include "server/config/expand/stability_report.h"
#include "server/recording/report_file.h"

#include <asio/post.hpp>
#include <asio/signal_set.hpp>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <set>

namespace zoned::app {

namespace {

constexpr auto kFarewell = std::chrono::seconds(2);
constexpr auto kStatusEvery = std::chrono::seconds(10);
constexpr auto kWatchEvery = std::chrono::seconds(1);
constexpr auto kDrainLook = std::chrono::milliseconds(50);
/// How old the admin server's figures of the tick loop may be.
constexpr double kPublishEvery_s = 0.25;

using Outcome = core::Result<AdminOutcome>;

/// One run of the server: world, loop, network, signals; all wiring and nothing else.
class Server {
  public:
    /// `seat` is null for a server that is in no cluster.
    Server(const ServeArguments& arguments, const config::Settings& settings, ClusterSeat* seat)
        : arguments_(arguments),
          settings_(settings),
          signals_(io_, SIGINT, SIGTERM),
          reload_signal_(io_, SIGHUP),
          stop_timer_(io_),
          status_timer_(io_),
          watch_timer_(io_),
          drain_timer_(io_),
          world_(settings, thread_count(settings), &thread_cpu_ns),
          recovery_(settings, world_, seat != nullptr ? seat->life() : std::string()),
          store_(settings),
          cluster_(io_, store_, seat),
          network_(io_, settings, poster(), cluster_.store_login(), cluster_.find_world()),
          live_(io_,
                settings,
                {[this](mailbox::NewBrains brains) { return loop_->post(std::move(brains)); },
                 [this](const session::HostLimits& limits) {
                     network_.host().set_limits(limits);
                 }}),
          supervision_(io_, settings.server, [this] { return loop_->turns(); }) {
        reserve_report();
        open_recording();
        open_device();
        LoopSettings loop;
        loop.rate_hz = settings.tick_rate_hz;
        loop.max_catch_up = settings.server.run.max_catch_up_ticks;
        loop.mailbox_capacity = settings.server.run.mailbox_capacity * settings.zones.size();
        loop.publish_every_s = settings.server.network.admin ? kPublishEvery_s : 0.0;
        if (settings.server.run.on_exception == config::RulesException::kStopServer) {
            loop.on_stopped_zone = [this] {
                asio::post(io_, [this] {
                    failed_ = true;
                    stop("the rules of a zone threw (run.on_exception)");
                });
            };
        }
        loop.to_store = [this](Tick tick, std::vector<mailbox::StoreRequest>&& requests) {
            return ask_store(tick, std::move(requests));
        };
        join_cluster();
        loop.cluster = cluster_.on() ? &settings : nullptr;
        if (recovery_.watches_ticks()) {
            loop.after_tick = [this](std::span<const mailbox::InboxItem> in,
                                     std::vector<mailbox::OutboxItem>& out) {
                recovery_.after_tick(in, out, *recorder_);
            };
        }
        loop_ = std::make_unique<TickLoop>(
            world_,
            loop,
            [this](TickResult result) {
                deliveries_.enter();
                asio::post(io_, [this, moved = std::make_shared<TickResult>(std::move(result))] {
                    cluster_.deliver(std::move(*moved));
                    deliveries_.leave();
                });
            },
            recorder_.get());
        network_.set_tick_begun([this] { return loop_->begun(); });
        if (settings.replication.codec == replication::Codec::kAuto) {
            loop_->post(logged(measure_codec()));
        }
        if (settings.server.network.admin) {
            admin_ = std::make_unique<AdminApi>(
                settings, *loop_, io_, network_, store_, admin_actions());
        }
    }

    ~Server() {
        deliveries_.open();  // nobody delivers any more
        cluster_.stop();     // before what its threads ask goes away
        cluster_.release();
    }

    int run() {
        const double begin = steady_seconds();
        const double cpu_begin = process_cpu_seconds();
        signals_.async_wait([this](const asio::error_code& error, int signal) {
            if (!error) {
                stop(signal == SIGINT ? "interrupted" : "asked to stop");
            }
        });
        await_reload();
        if (arguments_.seconds > 0.0) {
            stop_timer_.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(
                std::chrono::duration<double>(arguments_.seconds)));
            stop_timer_.async_wait([this](const asio::error_code& error) {
                if (!error) {
                    stop("its time is over");
                }
            });
        }
        advertised_ = supervision_.find_address();
        if (advertised_.udp_port != 0) {
            network_.host().set_udp_port(advertised_.udp_port);
        }
        store_.start(network_.host(),
                     {[this](mailbox::StoreAnswer answer) { loop_->post(std::move(answer)); },
                      [this](std::uint64_t number) {
                          recovery_.stored(number, poster());
                          asio::post(io_, [this, number] { network_.on_durable(number); });
                      }});
        go_on();
        network_.start();
        loop_->start();
        if (admin_) {
            admin_->start();
        }
        cluster_.listen(advertised_, *loop_);
        announce();
        watch();
        if (settings_.replication.meter) {
            log_status();
        }
        io_.run();
        return finish(steady_seconds() - begin, process_cpu_seconds() - cpu_begin);
    }

  private:
    ServerRecovery::Post poster() {
        return [this](mailbox::InboxItem item) {
            loop_->post(std::move(item));
        };
    }

    std::set<std::string> reclaim() {
        try {
            return cluster_.reclaim(recovery_.accounts());
        } catch (...) {
            recovery_.refused();
            throw;
        }
    }

    /// With what a server left that died, if one did.
    void go_on() {
        if (recovery_.on()) {
            network_.await_journal(world_.now());
            cluster_.await_journal([this] { return loop_->begun(); });
            const std::set<std::string> elsewhere = reclaim();
            recovery_.restore_sessions(network_.host(), elsewhere, poster());
            ask_store(world_.now(), recovery_.requests_again(elsewhere, poster()));
        }
    }

    void join_cluster() {
        cluster_.join(
            settings_,
            network_,
            [this](const std::string& why) {
                failed_ = true;
                stop(why);
            },
            [this](double grace_s) { drain(grace_s); });
    }

    StoreTicket ask_store(Tick tick, std::vector<mailbox::StoreRequest>&& requests) {
        if (requests.empty()) {
            return {};
        }
        const StoreTicket ticket = store_.submit(tick, std::move(requests));
        recovery_.asked(tick, ticket, poster());
        return ticket;
    }

    void await_reload() {
        reload_signal_.async_wait([this](const asio::error_code& error, int) {
            if (!error) {
                reload([](const Outcome&) {});
                await_reload();
            }
        });
    }

    AdminActions admin_actions() {
        AdminActions actions;
        actions.drain = [this](double grace_s) {
            drain(grace_s);
        };
        actions.reload = [this](AdminDone done) {
            reload(std::move(done));
        };
        actions.set = [this](const std::string& path, const std::string& value, AdminDone done) {
            live_.change(path, value, [done = std::move(done)](const LiveSettings::Taken& changes) {
                tell_changes("", changes, done);
            });
        };
        actions.record = [this](bool on, const std::string& name, const AdminDone& done) {
            with_recorder(done, [&](const recording::RecordingAnswer& answer) {
                if (on) {
                    record_from_now(*loop_, *recorder_, recording_path(settings_, name), answer);
                } else {
                    recorder_->stop_file(answer);
                }
            });
        };
        if (recovery_.on()) {
            actions.recovery = [this] {
                return recovery_.figures();
            };
        }
        if (cluster_.on()) {
            actions.cluster = [this] {
                return cluster_.figures();
            };
        }
        actions.snapshot = [this](const std::string& name, const AdminDone& done) {
            with_recorder(done, [&](recording::RecordingAnswer answer) {
                recorder_->snapshot(recording_path(settings_, name), std::move(answer));
            });
        };
        return actions;
    }

    /// Gives `ask` an answer that logs and tells.
    template <class Ask>
    void with_recorder(const AdminDone& done, Ask ask) {
        if (!recorder_) {
            tell(Outcome::failure("no inputs are kept: recording.file is empty, and "
                                  "recording.ring_s is 0"),
                 done);
            return;
        }
        ask([done](const core::Result<std::string>& result) {
            tell(
                result.ok() ? Outcome(AdminOutcome{*result, {}}) : Outcome::failure(result.error()),
                done);
        });
    }

    void reload(AdminDone done) {
        live_.reload(arguments_.config,
                     arguments_.sets,
                     [this, done = std::move(done)](const LiveSettings::Taken& changes) {
                         if (admin_ && changes.ok()) {
                             admin_->set_waiting(*changes);
                         }
                         tell_changes(
                             arguments_.config + " is not taken, everything stays as it was: ",
                             changes,
                             done);
                     });
    }

    static void tell_changes(const std::string& refused,
                             const LiveSettings::Taken& changes,
                             const AdminDone& done) {
        tell(changes.ok() ? Outcome(AdminOutcome{text_of(*changes), *changes})
                          : Outcome::failure(refused + changes.error()),
             done);
    }

    static void tell(const Outcome& outcome, const AdminDone& done) {
        if (outcome.ok()) {
            log_of(LogArea::kServer).info("{}", outcome->text);
        } else {
            log_of(LogArea::kServer).error("{}", outcome.error());
        }
        done(outcome);
    }

    /// No logins any more; the server stops when the last session has gone, or after this long.
    void drain(double grace_s) {
        cluster_.set_draining();
        const std::string text = "the server is draining: try another one, or later";
        network_.host().set_draining(text);
        network_.host().notify(
            ClientId{},
            "the server closes in at most " + std::to_string(std::llround(grace_s)) + " s");
        drain_end_s_ = steady_seconds() + grace_s;
        await_drained();
    }

    void await_drained() {
        if (stopping_) {
            return;
        }
        if (network_.sessions().sessions == 0 || steady_seconds() >= drain_end_s_) {
            stop("drained");
            return;
        }
        drain_timer_.expires_after(kDrainLook);
        drain_timer_.async_wait([this](const asio::error_code& error) {
            if (!error) {
                await_drained();
            }
        });
    }

    void open_recording() {
        recording::RecorderSettings recorder = recorder_settings(settings_, world_);
        recovery_.keep_inputs(recorder, [this](Tick tick) {
            asio::post(io_, [this, tick, whole = recorder_->journal_is_whole()] {
                network_.on_journaled(tick);
                if (whole) {
                    cluster_.on_journaled(tick);
                }
            });
        });
        if (recorder.file.empty() && recorder.ring_s <= 0.0 && !recovery_.on()) {
            return;
        }
        recorder_ = std::make_unique<recording::Recorder>(
            std::move(recorder),
            [](const std::string& problem) { log_of(LogArea::kServer).error("{}", problem); });
        const auto opened = recorder_->open();
        if (!opened.ok()) {
            throw std::runtime_error(opened.error());
        }
        if (!recorder_->kept_ring().empty()) {
            log_of(LogArea::kServer)
                .warn("an earlier run did not end in good order; its last inputs: zoned replay {}",
                      recorder_->kept_ring());
        }
    }

    /// Before anything runs: a report that cannot be written is worth a word now.
    void reserve_report() {
        if (arguments_.report.empty()) {
            return;
        }
        const auto reserved = report_.reserve(arguments_.report);
        if (!reserved.ok()) {
            throw std::runtime_error(reserved.error());
        }
    }

    void open_device() {
        ParticleDevice& device = particle_device_;
        device = open_particle_device(settings_, world_.pool().threads());
        log_device(device, !settings_.particles.empty());
        if (device.device) {
            world_.use_device(device.device.get(), device.crossover, device.of_flocks);
        }
    }

    void announce() {
        log_of(LogArea::kServer)
            .info("world {}: {} zones, {} entities, {} threads, certificate sha256 {}",
                  settings_.world_name,
                  settings_.zones.size(),
                  settings_.initial.size(),
                  world_.pool().threads(),
                  network_.fingerprint());
        Log::drain();  // a script that waits for "ready" finds the fingerprint in the log
        const std::string line = fmt::format("ready tcp={} udp={} admin={} zones={}{}",
                                             network_.tcp_port(),
                                             network_.udp_port(),
                                             admin_ ? admin_->port() : 0,
                                             settings_.zones.size(),
                                             addresses_text(advertised_, network_));
        std::printf("%s\n", line.c_str());
        std::fflush(stdout);
        supervision_.ready(line);
    }

    /// Tells what is dropped and refused when it happens.
    void watch() {
        watch_timer_.expires_after(kWatchEvery);
        watch_timer_.async_wait([this](const asio::error_code& error) {
            if (!error && !stopping_) {
                cluster_.note_sessions(network_.sessions().sessions);
                watch_.look({loop_->stats(),
                             network_.sessions(),
                             network_.tls(),
                             network_.udp(),
                             deliveries_.held(),
                             &settings_},
                            steady_seconds());
                watch();
            }
        });
    }

    void log_status() {
        status_timer_.expires_after(kStatusEvery);
        status_timer_.async_wait([this](const asio::error_code& error) {
            if (!error && !stopping_) {
                log_traffic({settings_, *loop_, network_, 1, 0.0, 0.0},
                            logged_traffic_,
                            std::chrono::duration<double>(kStatusEvery).count());
                log_status();
            }
        });
    }

    /// First the clients hear why, then the sockets close; a second signal does not wait.
    void stop(const std::string& why) {
        if (stopping_) {
            return;
        }
        stopping_ = true;
        log_of(LogArea::kServer).info("stopping: {}", why);
        supervision_.stopping(why);
        if (admin_) {
            admin_->set_draining();
        }
        drain_timer_.cancel();
        stop_timer_.cancel();
        status_timer_.cancel();
        watch_timer_.cancel();
        network_.shutdown("the server closes: " + why);
        farewell_end_ = std::chrono::steady_clock::now() + kFarewell;
        signals_.async_wait([this](const asio::error_code& error, int) {
            if (!error) {
                farewell_end_ = std::chrono::steady_clock::now();
            }
        });
        say_farewell();
    }

    void say_farewell() {
        if (network_.connections() == 0 || std::chrono::steady_clock::now() >= farewell_end_) {
            if (admin_) {
                admin_->stop();
            }
            deliveries_.open();
            loop_->stop();
            stop_rules();
            cluster_.stop();
            failed_ = store_.stop() > 0 || failed_;
            cluster_.release();
            network_.close();
            signals_.cancel();
            reload_signal_.cancel();
            supervision_.stopped();
            return;
        }
        stop_timer_.expires_after(std::chrono::milliseconds(20));
        stop_timer_.async_wait([this](const asio::error_code& error) {
            if (!error) {
                say_farewell();
            }
        });
    }

    /// Their last requests and lines reach store and log before these close.
    void stop_rules() {
        world_.stop();
        if (!world_.store_requests().empty()) {
            store_.submit(world_.now(), std::move(world_.store_requests()));
        }
        for (std::size_t i = 0; i < world_.zones().size(); ++i) {
            for (const std::string& line : world_.zones()[i]->output().lines) {
                log_of(LogArea::kWorld).info("rules of zone {}: {}", i + 1, line);
            }
        }
    }

    int finish(double seconds, double cpu_seconds) {
        live_.finish();
        core::Result<bool> recorded = true;
        if (recorder_) {
            recovery_.stop_ring();
            recorded = recorder_->close(failed_);
        }
        failed_ = !recovery_.end() || failed_;
        const ServeFigures figures{
            settings_, *loop_, network_, world_.pool().threads(), seconds, cpu_seconds};
        log_summary(figures);
        if (!arguments_.report.empty()) {
            const auto written = report_.commit(serve_report(figures));
            if (!written.ok()) {
                throw std::runtime_error(written.error());
            }
        }
        if (!recorded.ok()) {
            throw std::runtime_error(recorded.error());
        }
        return failed_ ? kFailed : kGood;
    }

    ServeArguments arguments_;
    const config::Settings& settings_;
    asio::io_context io_;
    asio::signal_set signals_;
    asio::signal_set reload_signal_;
    asio::steady_timer stop_timer_;
    asio::steady_timer status_timer_;
    asio::steady_timer watch_timer_;
    CounterWatch watch_;
    asio::steady_timer drain_timer_;
    double drain_end_s_ = 0.0;
    bool stopping_ = false;
    bool failed_ = false;
    wire::TrafficTable logged_traffic_;
    std::chrono::steady_clock::time_point farewell_end_;
    ParticleDevice particle_device_;  // outlives the world
    World world_;
    DeliveryGate deliveries_;
    ServerRecovery recovery_;
    ServerStore store_;
    ClusterWiring cluster_;
    Network network_;
    LiveSettings live_;
    Supervision supervision_;
    config::AdvertiseSettings advertised_;
    recording::ReportFile report_;
    std::unique_ptr<recording::Recorder> recorder_;
    std::unique_ptr<TickLoop> loop_;
    std::unique_ptr<AdminApi> admin_;
};

}  // namespace

int serve(const ServeArguments& arguments) {
    config::Settings settings;
    if (!load_or_complain(arguments.config, arguments.sets, settings)) {
        return kUsage;
    }
    if (const std::string wrong = wrong_with_cluster(arguments.cluster, settings); !wrong.empty()) {
        std::fprintf(stderr, "zoned: %s\n", wrong.c_str());
        return kUsage;
    }
    const Log log(settings.server.log);
    const std::string& folder = settings.server.session.state_folder;
    if (const std::string before = newest_crash_file(folder); !before.empty()) {
        log_of(LogArea::kServer)
            .warn("a run before this one crashed; {} says where (move it away when it was read)",
                  before);
    }
    install_crash_file(folder);
    log_start(settings);
    settings.replication.meter = settings.replication.meter || !arguments.report.empty();
    for (const std::string& warning : config::stability_warnings_of(settings)) {
        log_of(LogArea::kServer).warn("{}", warning);
    }
    std::unique_ptr<ClusterSeat> seat;
    if (!settings.server.cluster.name.empty()) {
        seat = std::make_unique<ClusterSeat>(settings, arguments.cluster);
    }
    Server server(arguments, settings, seat.get());
    return server.run();
}

}  // namespace zoned::app
