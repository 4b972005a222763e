// The command line of `zoned ctl`.
#include "server/app/commands/commands.h"
#include "server/config/server_settings.h"

#include <CLI/CLI.hpp>

namespace zoned::app {

namespace {

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

void add_world_orders(CLI::App& c, CtlArguments& a, std::function<int()>& run) {
    CLI::App* spawn = add_order(c, a, run, "spawn", "Put an entity into the world");
    spawn->add_option("TYPE", a.text, "As in the config")->required();
    spawn->add_option("--at", a.position_m, "World coordinates, m: x y z")->required()->expected(3);
    spawn->add_option("--yaw", a.yaw_deg, "Characters: 0 looks along z, 90 along x; degrees");
    CLI::App* move = add_order(c, a, run, "move", "Move an entity, with all that hangs on it");
    move->add_option("ENTITY", a.entity)->required()->check(CLI::PositiveNumber);
    move->add_option("--to", a.position_m, "World coordinates, m: x y z")->required()->expected(3);
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
    add_order(c, a, run, "reload", "Read the config again, as on SIGHUP; tells what changed");
    CLI::App* level = add_order(c, a, run, "log-level", "What the log holds from now on");
    level->add_option("LEVEL", a.text)
        ->required()
        ->check(CLI::IsMember({"debug", "info", "warning", "error"}));
    level->add_option("--area", a.area, "Of the log; default: all areas")
        ->check(CLI::IsMember(
            std::vector<std::string>(config::kLogAreaNames.begin(), config::kLogAreaNames.end())));
    CLI::App* record = add_order(c, a, run, "record", "End the recording of the run, or begin one");
    record->add_option("on|off", a.text)->required()->check(CLI::IsMember({"on", "off"}));
    record->add_option(
        "--file", a.file, "Name in the state folder's recordings; default: the time");
    record->footer(
        "A recording that begins while the world runs starts with its state, and so does a "
        "replay.\n"
        "The tick of its beginning takes as much longer as the state takes to write.");
    add_order(c, a, run, "snapshot", "Write the run up to now into a recording of its own")
        ->add_option("--file", a.file, "Name in the state folder's recordings; default: the time");
    add_world_orders(c, a, run);
}

}  // namespace

void add_ctl(CLI::App& app, CtlArguments& a, std::function<int()>& run) {
    CLI::App* c = app.add_subcommand("ctl", "Look at a running server, or tell it something");
    c->require_subcommand(1);
    c->add_option("--state", a.state, "The server's session.state_folder; default: state");
    c->add_option(
        "--admin", a.admin, "HOST:PORT, or https://HOST:PORT; default: as the state folder says");
    c->add_option("--token-file", a.token_file, "Default: admin.token in the state folder");
    c->add_option("--certificate",
                  a.certificate,
                  "PEM file that a server with TLS is known by; default: admin.certificate in the "
                  "state folder");
    c->add_flag("--json", a.json, "Print the server's answer as it came");
    c->footer(
        "Exit 1: no such session, account or entity. Exit 2: a mistake. Exit 3: no answer.\n"
        "Examples:\n"
        "  zoned ctl --state config/state status\n"
        "  zoned ctl --state config/state kick --name ann --reason \"be kind\"\n"
        "  zoned ctl --state config/state snapshot --file before_the_fall.zrec\n"
        "  zoned ctl --state config/state spawn crate --at 10 5 -20\n"
        "  zoned ctl --admin https://game.example.org:7780 --token-file t --certificate c status");
    add_looks(*c, a, run);
    add_orders(*c, a, run);
}

}  // namespace zoned::app
