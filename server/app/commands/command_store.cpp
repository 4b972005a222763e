// zoned backup, restore and store: the durable store under an operator's hands.
#include "server/app/commands/commands.h"
#include "server/app/storage/server_store.h"
#include "server/config/text/store_url.h"
#include "server/store/postgres_store.h"
#include "server/store/sqlite_store.h"
#include "shared/core/hex.h"

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>

namespace zoned::app {

namespace {

std::string file_of(const StoreArguments& arguments) {
    return arguments.file.empty() ? arguments.state + "/store.db" : arguments.file;
}

int complain(const std::string& text) {
    std::fprintf(stderr, "zoned: %s\n", text.c_str());
    return kEnvironment;
}

core::Result<std::unique_ptr<store::Store>> open_to_inspect(const StoreArguments& arguments) {
    using Out = core::Result<std::unique_ptr<store::Store>>;
    if (!arguments.url.empty()) {
        if (const std::string why = config::wrong_with_store_url(arguments.url); !why.empty()) {
            return Out::failure("--url " + why);
        }
        auto opened = store::open_postgres_store(arguments.url, false);
        return opened.ok() ? Out(std::move(*opened)) : Out::failure(opened.error().text);
    }
    const std::string file = file_of(arguments);
    if (!std::filesystem::exists(file)) {
        return Out::failure(file +
                            ": there is no store; --state names session.state_folder of "
                            "the config, --file its store.file");
    }
    auto opened =
        store::open_sqlite_store(file, store::Durability::kPower, store::StoreUse::kInspect);
    return opened.ok() ? Out(std::move(*opened)) : Out::failure(opened.error().text);
}

std::string utc(std::int64_t unix_ms) {
    const std::time_t seconds = unix_ms / 1000;
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    char text[32];
    std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text;
}

void add_place(CLI::App& command, StoreArguments& a) {
    command.add_option("--state", a.state, "The server's session.state_folder; default: state");
    CLI::Option* file =
        command.add_option("--file", a.file, "The store itself, where the config sets store.file");
    command.add_option("--url", a.url, "The config's store.url, where it lies in PostgreSQL")
        ->excludes(file);
}

}  // namespace

int backup(const StoreArguments& arguments) {
    if (!arguments.url.empty()) {
        return complain("a store in PostgreSQL is backed up by PostgreSQL's own tools: pg_dump");
    }
    const auto opened = open_to_inspect(arguments);
    if (!opened.ok()) {
        return complain(opened.error());
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto done = (*opened)->backup(arguments.backup);
    if (!done.ok()) {
        return complain(done.error().text);
    }
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::error_code ignored;
    std::printf("wrote %s, %.1f MB in %.3f s\n",
                arguments.backup.c_str(),
                1e-6 * static_cast<double>(std::filesystem::file_size(arguments.backup, ignored)),
                seconds);
    return kGood;
}

int restore(const StoreArguments& arguments) {
    if (!arguments.url.empty()) {
        return complain(
            "a store in PostgreSQL comes back by PostgreSQL's own tools: pg_restore, or psql with "
            "what pg_dump wrote");
    }
    const auto kept = store::restore_sqlite(arguments.backup, file_of(arguments));
    if (!kept.ok()) {
        return complain(kept.error().text);
    }
    std::printf("restored %s from %s\n", file_of(arguments).c_str(), arguments.backup.c_str());
    if (!kept->empty()) {
        std::printf("what was there before is %s\n", kept->c_str());
    }
    return kGood;
}

int store_check(const StoreArguments& arguments) {
    const auto opened = open_to_inspect(arguments);
    if (!opened.ok()) {
        return complain(opened.error());
    }
    const auto found = (*opened)->check();
    if (!found.ok()) {
        return complain(found.error().text);
    }
    for (const std::string& text : *found) {
        std::printf("%s\n", text.c_str());
    }
    const auto counts = (*opened)->counts();
    if (!counts.ok()) {
        return complain(counts.error().text);
    }
    std::printf(
        "schema      %u\naccounts    %llu\ncharacters  %llu\nrecords     %llu\n"
        "bans        %llu\ntickets     %llu\nevents      %llu\n%s\n",
        counts->schema,
        static_cast<unsigned long long>(counts->accounts),
        static_cast<unsigned long long>(counts->characters),
        static_cast<unsigned long long>(counts->records),
        static_cast<unsigned long long>(counts->bans),
        static_cast<unsigned long long>(counts->tickets),
        static_cast<unsigned long long>(counts->events),
        found->empty() ? "whole" : "damaged: restore a backup");
    return found->empty() ? kGood : kFailed;
}

int store_events(const StoreArguments& arguments) {
    const auto opened = open_to_inspect(arguments);
    if (!opened.ok()) {
        return complain(opened.error());
    }
    const auto events = (*opened)->events(arguments.account, arguments.count);
    if (!events.ok()) {
        return complain(events.error().text);
    }
    for (const store::StoredEvent& event : *events) {
        std::printf("%lld  %s  tick %lld  zone %u  kind %u  %s  %s\n",
                    static_cast<long long>(event.number),
                    utc(event.unix_ms).c_str(),
                    static_cast<long long>(event.tick),
                    static_cast<unsigned>(event.zone),
                    static_cast<unsigned>(event.kind),
                    event.account.empty() ? (event.topic.empty() ? "-" : event.topic.c_str())
                                          : event.account.c_str(),
                    core::to_hex(event.payload).c_str());
    }
    return kGood;
}

void add_store(CLI::App& app, StoreArguments& a, std::function<int()>& run) {
    CLI::App* b = app.add_subcommand(
        "backup", "Copy the store of a server, running or not, into one new file");
    add_place(*b, a);
    b->add_option("OUT", a.backup, "File that is made; it must not be there yet")->required();
    b->footer("Example:\n  zoned backup --state state store-monday.db");
    b->callback([&] {
        run = [&a] {
            return backup(a);
        };
    });

    CLI::App* r = app.add_subcommand(
        "restore", "Put the store of a backup in place; the server must be stopped");
    add_place(*r, a);
    r->add_option("BACKUP", a.backup, "File that zoned backup made")->required();
    r->footer(
        "The backup is checked first. What was there before stays beside it.\n"
        "Example:\n  zoned restore --state state store-monday.db");
    r->callback([&] {
        run = [&a] {
            return restore(a);
        };
    });

    CLI::App* s = app.add_subcommand("store", "Look at the store of a server, running or not");
    s->require_subcommand(1);
    CLI::App* check = s->add_subcommand("check", "Read all of it: is it whole, and what it holds");
    add_place(*check, a);
    check->footer("Exit 1: it is damaged.\nExample:\n  zoned store check --state state");
    check->callback([&] {
        run = [&a] {
            return store_check(a);
        };
    });
    CLI::App* events =
        s->add_subcommand("events", "Print the newest durable events, payloads as hexadecimal");
    add_place(*events, a);
    events->add_option("--account", a.account, "Those of this account alone");
    events->add_option("--count", a.count, "So many at most; default: 20")
        ->check(CLI::Range(1U, 1000000U));
    events->footer("Example:\n  zoned store events --state state --account ann --count 100");
    events->callback([&] {
        run = [&a] {
            return store_events(a);
        };
    });
}

}  // namespace zoned::app
