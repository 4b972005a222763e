#include "server/app/commands/commands.h"

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
    c->footer(
        "Prints one line on standard output once it listens:\n"
        "  ready tcp=PORT udp=PORT admin=PORT zones=N\n"
        "Example:\n"
        "  zoned serve --config config/valley.txtpb --set network.tcp_port=7777 --report "
        "server.json");
    c->callback([&] {
        run = [&a] {
            return serve(a);
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
    c->add_option("--ticks", a.ticks, "Measure over this many ticks")
        ->check(CLI::Range(1U, 100000U));
    CLI::Option* diagram = c->add_option(
        "--diagram", a.diagram, "Print the diagram of this brain instead, for Graphviz");
    c->add_option("--svg", a.svg, "Have Graphviz draw it into this file")->needs(diagram);
    c->add_option("--why", a.entity, "Say why this entity does what it does, after these ticks")
        ->check(CLI::PositiveNumber)
        ->excludes(diagram);
    c->footer(
        "Examples:\n  zoned explain config/valley.txtpb --viewers 200\n"
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
    t->add_option("--right", a.rights, "play, audit, freeze or admin (repeatable); default: play")
        ->check(CLI::IsMember({"play", "audit", "freeze", "admin"}));
    t->add_option("--hours", a.hours, "Valid from now for this long")->check(CLI::PositiveNumber);
    t->add_option("--out", a.out, "Ticket file; default: standard output in hex");
    t->footer(
        "Example:\n  zoned ticket --key operator.key --account ann --right play --out ann.ticket");
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
    c->add_flag("--info", a.info, "Say what FILE holds and whether it is whole; simulates nothing")
        ->excludes(out);
    c->footer(
        "Exit 1: a hash differs or the file is damaged; all before the damage is replayed.\n"
        "Examples:\n  zoned serve --config world.txtpb --set recording.file=run.zrec --seconds 60\n"
        "  zoned replay run.zrec --threads 4   # it lies beside world.txtpb\n"
        "  zoned replay run.zrec --info\n"
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

/// One command of `zoned ctl`.
CLI::App* add_order(CLI::App& ctl,
                    CtlArguments& a,
                    std::function<int()>& run,
                    const std::string& name,
                    const std::string& help) {
    CLI::App* c = ctl.add_subcommand(name, help);
    c->callback([&a, &run, name] {
        a.command = name;
        run = [&a] {
            return app::ctl(a);
        };
    });
    return c;
}

void add_looks(CLI::App& c, CtlArguments& a, std::function<int()>& run) {
    add_order(c, a, run, "status", "The server at a glance");
    add_order(c, a, run, "sessions", "Clients that are logged in");
    add_order(c, a, run, "zones", "Zones, what they hold and what they cost");
    add_order(c, a, run, "bans", "Accounts that may not log in");
    add_order(c, a, run, "metrics", "All figures, as Prometheus reads them");
    add_order(
        c, a, run, "viewer", "The address at which a browser shows the world; it holds the token");
    add_order(c, a, run, "inspect", "One entity, and why its agent does what it does")
        ->add_option("ENTITY", a.entity)
        ->required()
        ->check(CLI::PositiveNumber);
    CLI::App* top = add_order(c, a, run, "top", "A table that renews itself");
    top->add_option("--every", a.every_s, "Seconds between two looks")
        ->check(CLI::Range(0.05, 3600.0));
    top->add_option("--count", a.count, "So many looks; 0: until interrupted");
}

void add_orders(CLI::App& c, CtlArguments& a, std::function<int()>& run) {
    CLI::App* kick = add_order(c, a, run, "kick", "End sessions; their clients are told why");
    CLI::Option_group* who = kick->add_option_group("who");
    who->add_option("--client", a.client, "By number")->check(CLI::PositiveNumber);
    who->add_option("--account", a.account, "All of an account");
    who->add_option("--name", a.name, "All with a name");
    who->require_option(1);
    kick->add_option("--reason", a.reason, "Told to the client");
    CLI::App* ban = add_order(c, a, run, "ban", "End an account's sessions, refuse its logins");
    ban->add_option("ACCOUNT", a.account)->required();
    ban->add_option("--hours", a.hours, "For so long; 0: for ever")->check(CLI::NonNegativeNumber);
    ban->add_option("--reason", a.reason, "Told to the client");
    add_order(c, a, run, "unban", "Let an account log in again")
        ->add_option("ACCOUNT", a.account)
        ->required();
    CLI::App* say = add_order(c, a, run, "say", "Send a text to players, as a reliable event");
    say->add_option("TEXT", a.text)->required();
    say->add_option("--client", a.client, "To one client; default: to all");
    add_order(c, a, run, "drain", "Take no logins; stop when all have left or the grace is over")
        ->add_option("--grace", a.grace_s, "Seconds that sessions may go on; default: 30")
        ->check(CLI::Range(0.0, 86400.0));
    add_order(c, a, run, "set", "Change a setting until the server stops")
        ->add_option("PATH=VALUE", a.text)
        ->required();
    add_order(c, a, run, "reload", "Read the brains of the config again, as on SIGHUP");
    add_order(c, a, run, "log-level", "What the log holds from now on")
        ->add_option("LEVEL", a.text)
        ->required()
        ->check(CLI::IsMember({"debug", "info", "warning", "error"}));
}

void add_ctl(CLI::App& app, CtlArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand("ctl", "Look at a running server, or tell it something");
    c->require_subcommand(1);
    c->add_option("--state", a.state, "The server's session.state_folder; default: state");
    c->add_option("--admin", a.admin, "HOST:PORT; default: as the state folder says");
    c->add_option("--token-file", a.token_file, "Default: admin.token in the state folder");
    c->add_flag("--json", a.json, "Print the server's answer as it came");
    c->footer(
        "Exit 1: no such session, account or entity. Exit 2: a mistake. Exit 3: no answer.\n"
        "Examples:\n"
        "  zoned ctl --state config/state status\n"
        "  zoned ctl --state config/state kick --name ann --reason \"be kind\"");
    add_looks(*c, a, run);
    add_orders(*c, a, run);
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
    ExplainArguments explain_arguments;
    TicketArguments ticket_arguments;
    ReplayArguments replay_arguments;
    BakeArguments bake_arguments;
    TrainArguments train_arguments;
    CtlArguments ctl_arguments;
    std::string key_base;
    std::function<int()> run;
    add_serve(app, serve_arguments, run);
    add_check(app, check_arguments, run);
    add_explain(app, explain_arguments, run);
    add_bake(app, bake_arguments, run);
    add_keys(app, key_base, ticket_arguments, run);
    add_replay(app, replay_arguments, run);
    add_train(app, train_arguments, run);
    add_ctl(app, ctl_arguments, run);
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
