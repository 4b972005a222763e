#include "server/app/commands/commands.h"
#include "server/app/commands/describe_commands.h"
#include "server/app/commands/restarts.h"

#include <CLI/CLI.hpp>
#include <google/protobuf/stubs/logging.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <system_error>

namespace zoned::app {

namespace {

void add_sets(CLI::App& command, std::vector<std::string>& sets) {
    command.add_option("--set", sets, "Override a setting: path.to.field=value (repeatable)")
        ->type_name("PATH=VALUE");
}

void add_serve(CLI::App& app, ServeArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand("serve", "Run a server until SIGTERM, SIGINT or --seconds");
    c->add_option("--config", a.config, "World and server settings, protobuf text format")
        ->required();
    add_sets(*c, a.sets);
    c->add_option("--seconds", a.seconds, "Stop by itself after this long; 0: never")
        ->check(CLI::NonNegativeNumber);
    c->add_option("--report", a.report, "Write a JSON report here on exit");
    c->add_flag("--restart", a.restart, "Start the server again when it dies (see recovery.on)");
    c->add_option("--cluster",
                  a.cluster,
                  "NATS servers of the cluster, nats://HOST:PORT or tls://HOST:PORT, with commas "
                  "between (repeatable; environment: ZONED_CLUSTER)")
        ->envname("ZONED_CLUSTER");
    c->footer(
        "With --cluster and cluster.name in the config the server first waits until no other one\n"
        "has its world: a second server of a world stands by, and takes it when the first is "
        "gone.\n"
        "Prints one line on standard output once it listens:\n"
        "  ready tcp=PORT udp=PORT admin=PORT zones=N\n"
        "Example:\n"
        "  zoned serve --config config/valley.txtpb --set network.tcp_port=7777 --report "
        "server.json");
    c->callback([&] {
        run = [&a] {
            return a.restart ? restart_when_it_dies([&a] { return serve(a); }) : serve(a);
        };
    });
}

void add_new(CLI::App& app, NewArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand(
        "new", "Begin a game of your own: rules, world, test, image, in a folder of its own");
    c->add_option("DIR", a.folder, "Folder to make; nothing is overwritten")->required();
    c->add_option("--name", a.name, "Of the game; default: the last part of DIR");
    c->add_option("--game", a.game, "To begin with: tag, or capture_the_flag with bots of its own")
        ->check(CLI::IsMember({"tag", "capture_the_flag"}));
    c->add_flag("--lua", a.lua, "Rules in a script; default: in C++, linked into a server");
    c->add_flag("--test", a.test, "Then build the game and run its test");
    c->footer(
        "A game in C++ needs the package zoned-dev, or a build folder of zoned.\n"
        "Examples:\n"
        "  zoned new my_game --test\n"
        "  zoned new my_game --lua\n"
        "  zoned new my_game --game capture_the_flag");
    c->callback([&] {
        run = [&a] {
            return new_game(a);
        };
    });
}

void add_check(CLI::App& app, ServeArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand(
        "check",
        "Report every mistake in a config, with line and column, and what warnings the physics");
    c->add_option("FILE", a.config)->required();
    add_sets(*c, a.sets);
    c->footer("Example:\n  zoned check config/valley.txtpb");
    c->callback([&] {
        run = [&a] {
            return check(a.config, a.sets);
        };
    });
}

void add_explain(CLI::App& app, ExplainArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand(
        "explain", "Print each zone's plan: which passes run, why, and what they cost");
    c->add_option("FILE", a.config)->required();
    add_sets(*c, a.sets);
    c->add_option("--viewers", a.viewers, "Let this many players stand in the world")
        ->check(CLI::Range(0U, 10000U));
    c->add_option("--bots", a.bots, "Let this many players walk about in the world")
        ->check(CLI::Range(0U, 10000U));
    c->add_option("--ticks", a.ticks, "Measure over this many ticks")
        ->check(CLI::Range(1U, 100000U));
    CLI::Option* analyze =
        c->add_flag("--analyze", a.analyze, "Run on, and print expected beside actual");
    c->add_option("--seconds", a.seconds, "Run on for this long, of the world's time")
        ->needs(analyze)
        ->check(CLI::Range(0.1, 3600.0));
    c->add_flag("--json", a.json, "Print the analysis as JSON")->needs(analyze);
    CLI::Option* diagram = c->add_option(
        "--diagram", a.diagram, "Print the diagram of this brain instead, for Graphviz");
    c->add_option("--svg", a.svg, "Have Graphviz draw it into this file")->needs(diagram);
    c->add_option("--why", a.entity, "Say why this entity does what it does, after these ticks")
        ->check(CLI::PositiveNumber)
        ->excludes(diagram);
    c->footer(
        "Examples:\n  zoned explain config/valley.txtpb --viewers 200\n"
        "  zoned explain config/valley.txtpb --analyze --seconds 10 --bots 20\n"
        "  zoned explain config/valley.txtpb --diagram guard --svg guard.svg\n"
        "  zoned explain config/valley.txtpb --viewers 20 --ticks 300 --why 2300");
    c->callback([&] {
        run = [&a] {
            return a.diagram.empty() ? explain(a) : explain_diagram(a);
        };
    });
}

void add_bake(CLI::App& app, BakeArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand(
        "bake", "Check a static surface (OBJ mesh or PNG heightfield) and write it ready to load");
    c->add_option("FILE", a.file, "Told apart by content: OBJ text, PNG image or baked file")
        ->required();
    c->add_option("--out", a.out, "Write here; default: FILE.baked");
    c->add_flag("--check", a.check, "Check and report only, a baked file too; writes nothing");
    c->add_option("--scale", a.scale, "OBJ: metres per unit; default: 1")
        ->check(CLI::PositiveNumber);
    c->add_option("--weld", a.weld, "OBJ: vertices no farther apart are one, m; default: 0")
        ->check(CLI::NonNegativeNumber);
    c->add_option("--height", a.height, "PNG: metres from black to white; no default");
    c->add_option("--spacing", a.spacing, "PNG: metres between pixels; default: 1")
        ->check(CLI::PositiveNumber);
    c->add_option("--offset", a.offset, "PNG: height of black, m; default: 0");
    c->add_option("--thickness", a.thickness, "PNG: solid below the lowest pixel, m; default: 1")
        ->check(CLI::NonNegativeNumber);
    c->add_option("--error-budget",
                  a.error_budget_m,
                  "What is smaller than this is warned of, m; default: 0.005")
        ->check(CLI::Range(0.00001, 1.0));
    c->footer(
        "Mistakes are printed with line (OBJ) or row (PNG); exit 2 when there is one.\n"
        "Examples:\n"
        "  zoned bake town.obj --scale 0.01\n"
        "  zoned bake hills.png --height 120 --spacing 2 --out hills.baked\n"
        "  zoned bake --check hills.baked");
    c->callback([&] {
        run = [&a] {
            return bake(a);
        };
    });
}

void add_keys(CLI::App& app, std::string& base, TicketArguments& a, std::function<int()>& run) {
    CLI::App* k = app.add_subcommand("keygen", "Make an Ed25519 key pair for login tickets");
    k->add_option("BASE", base, "Writes BASE.key (private, mode 0600) and BASE.pub")->required();
    k->footer(
        "Example:\n  zoned keygen operator   # then: session { ticket_public_key_file: "
        "\"operator.pub\" }");
    k->callback([&] {
        run = [&base] {
            return keygen(base);
        };
    });

    CLI::App* t = app.add_subcommand("ticket", "Sign a login ticket");
    t->add_option("--key", a.key, "Private key file made by keygen")->required();
    t->add_option("--account", a.account, "Account, 1..64 bytes")->required();
    t->add_option("--name", a.name, "Name shown to others; default: the account");
    t->add_option("--team", a.team, "Team; default: none");
    t->add_option("--world", a.world, "Opens this world alone; default: any that trusts the key");
    t->add_option("--right", a.rights, "play, audit, freeze or admin (repeatable); default: play")
        ->check(CLI::IsMember({"play", "audit", "freeze", "admin"}));
    t->add_option("--hours", a.hours, "Valid from now for this long")->check(CLI::PositiveNumber);
    t->add_option("--out", a.out, "Ticket file; default: a line of base64 on standard output");
    t->footer(
        "Examples:\n  zoned ticket --key operator.key --account ann --right play --out ann.ticket\n"
        "  zoned ticket --key operator.key --account bob >>tickets.txt   # one ticket a line\n"
        "  client-sim --connect localhost:7777 --bots 1 --ticket tickets.txt ...");
    t->callback([&] {
        run = [&a] {
            return ticket(a);
        };
    });
}

void add_replay(CLI::App& app, ReplayArguments& a, std::function<int()>& run) {
    CLI::App* c =
        app.add_subcommand("replay", "Re-simulate a recording and compare every tick's state hash");
    c->add_option("FILE", a.file, "A recording, or a folder with the last inputs of a server")
        ->required();
    c->add_option("--threads", a.threads, "Threads that step zones")->check(CLI::Range(1U, 256U));
    c->add_option("--from", a.from, "First tick to compare (all before are simulated) or to copy")
        ->check(CLI::PositiveNumber);
    c->add_option("--to", a.to, "Last tick")->check(CLI::PositiveNumber);
    CLI::Option* out =
        c->add_option("--out", a.out, "Copy these ticks into a recording; simulates nothing");
    CLI::Option* info =
        c->add_flag(
             "--info", a.info, "Say what FILE holds and whether it is whole; simulates nothing")
            ->excludes(out);
    CLI::Option* show =
        c->add_flag("--serve", a.serve, "Show it in a browser, with a slider, until a signal comes")
            ->excludes(out)
            ->excludes(info);
    c->add_option("--port", a.port, "Of --serve, on this machine alone; default: any free one")
        ->needs(show);
    c->footer(
        "Exit 1: a hash differs or the file is damaged; all before the damage is replayed.\n"
        "Examples:\n  zoned serve --config world.txtpb --set recording.file=run.zrec --seconds 60\n"
        "  zoned replay run.zrec --threads 4   # it lies beside world.txtpb\n"
        "  zoned replay run.zrec --info\n"
        "  zoned replay run.zrec --serve   # prints the address for a browser\n"
        "  zoned replay run.zrec --to 900 --out begin.zrec\n"
        "  zoned replay state/ring-20260131T120000   # after a crash");
    c->callback([&] {
        run = [&a] {
            return replay(a);
        };
    });
}

void add_train(CLI::App& app, TrainArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand(
        "train", "Train a network for a task or after recorded players, and write it as a policy");
    c->add_option(
         "FILE", a.file, "What to learn and how, protobuf text format (proto/training.proto)")
        ->required();
    CLI::Option* resume = c->add_flag("--resume", a.resume, "Go on from the checkpoint");
    c->add_flag("--restart", a.restart, "Begin anew although there is a checkpoint")
        ->excludes(resume);
    c->add_option("--threads", a.threads, "Threads that judge a generation; the result is the same")
        ->check(CLI::Range(1U, 256U));
    c->footer(
        "SIGINT and SIGTERM write a checkpoint and end; the same seed gives the same policy,\n"
        "interrupted or not. Exit 1 where target_score is not reached.\n"
        "Examples:\n"
        "  zoned train config/training/arena.txtpb --threads 4\n"
        "  zoned train config/training/arena.txtpb --resume\n"
        "  zoned serve --config config/minimal.txtpb --set recording.file=run.zrec --seconds 60\n"
        "  zoned train imitate.txtpb   # with task: IMITATION, imitation { recording: "
        "\"config/run.zrec\" ... }");
    c->callback([&] {
        run = [&a] {
            return train(a);
        };
    });
}

void add_descriptions(CLI::App& app, std::function<int()>& run) {
    CLI::App* completion =
        app.add_subcommand("completion", "Print completions of commands and options for a shell");
    completion->add_subcommand("bash", "For bash: source <(zoned completion bash)")
        ->callback([&app, &run] {
            run = [&app] {
                std::fputs(bash_completion(app).c_str(), stdout);
                return kGood;
            };
        });
    completion->require_subcommand(1);
    app.add_subcommand("manual", "Print the manual page, as man reads it")->callback([&app, &run] {
        run = [&app] {
            std::fputs(manual_page(app).c_str(), stdout);
            return kGood;
        };
    });
}

}  // namespace

int run_command_line(int argc, char** argv) {
    // protobuf would write a line for every malformed string that a client sends; the sessions
    // count them instead.
    google::protobuf::SetLogHandler(nullptr);
    CLI::App app("zoned: a dedicated authoritative multiplayer game server", "zoned");
    app.require_subcommand(1);
    app.set_version_flag("--version", "zoned " ZONED_VERSION ", built for " ZONED_TARGET_NAME);
    ServeArguments serve_arguments;
    ServeArguments check_arguments;
    NewArguments new_arguments;
    ExplainArguments explain_arguments;
    TicketArguments ticket_arguments;
    ReplayArguments replay_arguments;
    BakeArguments bake_arguments;
    TrainArguments train_arguments;
    CtlArguments ctl_arguments;
    StoreArguments store_arguments;
    ClusterArguments cluster_arguments;
    std::string key_base;
    std::function<int()> run;
    add_serve(app, serve_arguments, run);
    add_new(app, new_arguments, run);
    add_check(app, check_arguments, run);
    add_explain(app, explain_arguments, run);
    add_bake(app, bake_arguments, run);
    add_keys(app, key_base, ticket_arguments, run);
    add_replay(app, replay_arguments, run);
    add_train(app, train_arguments, run);
    add_ctl(app, ctl_arguments, run);
    add_store(app, store_arguments, run);
    add_cluster(app, cluster_arguments, run);
    add_descriptions(app, run);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? kGood : kUsage;
    }
    try {
        return run();
    } catch (const std::system_error& error) {
        std::fprintf(stderr, "zoned: %s\n", error.what());
        return kEnvironment;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned: %s\n", error.what());
        return kEnvironment;
    }
}

}  // namespace zoned::app
