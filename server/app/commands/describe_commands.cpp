#include "server/app/commands/describe_commands.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <functional>
#include <string_view>
#include <vector>

namespace zoned::app {

namespace {

/// Calls with each command and its words: "", " ctl", " ctl kick".
void walk(const CLI::App& app,
          const std::string& path,
          const std::function<void(const CLI::App&, const std::string&)>& visit) {
    visit(app, path);
    for (const CLI::App* command :
         app.get_subcommands([](const CLI::App* c) { return !c->get_name().empty(); })) {
        walk(*command, path + " " + command->get_name(), visit);
    }
}

/// Options of option groups are among them.
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
    std::vector<const CLI::Option*> out = app.get_options();
    for (const CLI::App* group :
         app.get_subcommands([](const CLI::App* c) { return c->get_name().empty(); })) {
        const auto inner = options_of(*group);
        out.insert(out.end(), inner.begin(), inner.end());
    }
    return out;
}

/// "a b c" of a type "TEXT:{a,b,c}"; empty for any other.
std::string values_of(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const std::size_t open = type.find('{');
    const std::size_t close = type.find('}');
    if (open == std::string::npos || close == std::string::npos || close < open) {
        return {};
    }
    std::string list = type.substr(open + 1, close - open - 1);
    std::replace(list.begin(), list.end(), ',', ' ');
    return list;
}

std::string words_of(const CLI::App& app) {
    std::string out;
    for (const CLI::App* command :
         app.get_subcommands([](const CLI::App* c) { return !c->get_name().empty(); })) {
        out += command->get_name() + " ";
    }
    for (const CLI::Option* option : options_of(app)) {
        out += option->get_positional() ? values_of(*option) + " "
                                        : option->get_name(false, true) + " ";
    }
    std::replace(out.begin(), out.end(), ',', ' ');
    return out;
}

/// Text for roff: a backslash is an escape, a dot or quote at the start of a line a request.
std::string roff(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool starts = i == 0 || text[i - 1] == '\n';
        if (starts && (text[i] == '.' || text[i] == '\'')) {
            out += "\\&";
        }
        out += text[i] == '\\' ? "\\e" : text[i] == '-' ? "\\-" : std::string(1, text[i]);
    }
    return out;
}

std::string man_of_command(const CLI::App& app, const std::string& path) {
    std::string out = ".SS \"zoned" + roff(path) + "\"\n" + roff(app.get_description()) + "\n";
    for (const CLI::Option* option : options_of(app)) {
        if (option->get_name() == "--help") {
            continue;
        }
        const bool flag = option->get_type_size() == 0;
        out +=
            ".TP\n.B " + roff(option->get_name(option->get_positional(), true)) +
            (flag || option->get_positional() ? ""
                                              : " \\fI" + roff(option->get_type_name()) + "\\fR") +
            "\n" + roff(option->get_description()) + (option->get_required() ? " (required)" : "") +
            "\n";
    }
    const std::string footer = app.get_footer();
    if (!footer.empty()) {
        out += ".PP\n.nf\n" + roff(footer) + "\n.fi\n";
    }
    return out;
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
    std::string paths;
    std::string words;
    std::string values;
    walk(app, "", [&](const CLI::App& command, const std::string& path) {
        if (!path.empty()) {
            paths += (paths.empty() ? "\"" : "|\"") + path + "\"";
        }
        words += "    \"" + path + "\") words=\"" + words_of(command) + "\" ;;\n";
        for (const CLI::Option* option : options_of(command)) {
            if (const std::string list = values_of(*option);
                !list.empty() && !option->get_positional()) {
                values += "    \"" + path + " " + option->get_name(false, true) + "\") words=\"" +
                          list + "\" ;;\n";
            }
        }
    });
    return "# Completion of zoned for bash: source <(zoned completion bash)\n"
           "_zoned() {\n"
           "  local cur=\"${COMP_WORDS[COMP_CWORD]}\" prev=\"${COMP_WORDS[COMP_CWORD-1]}\"\n"
           "  local path=\"\" words=\"\" word\n"
           "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
           "    case \"$path $word\" in " +
           paths +
           ") path=\"$path $word\" ;; esac\n"
           "  done\n"
           "  case \"$path\" in\n" +
           words +
           "  esac\n"
           "  case \"$path $prev\" in\n" +
           (values.empty() ? "" : values) +
           "  esac\n"
           "  COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
           "  if [[ ${#COMPREPLY[@]} -eq 0 && $cur != -* ]]; then\n"
           "    COMPREPLY=($(compgen -f -- \"$cur\"))\n"
           "  fi\n"
           "}\n"
           "complete -o filenames -F _zoned zoned\n";
}

std::string manual_page(const CLI::App& app) {
    std::string out = ".TH ZONED 1 \"\" \"zoned " ZONED_VERSION
                      "\" \"User Commands\"\n.SH NAME\nzoned \\- a dedicated authoritative "
                      "multiplayer game server\n.SH SYNOPSIS\n.B zoned\n.I COMMAND\n[\\fIOPTION\\fR"
                      "]...\n.SH DESCRIPTION\nOne process simulates physics and agents of every "
                      "zone of a world at a fixed tick, and sends each player the states around "
                      "it.\n.SH COMMANDS\n";
    walk(app, "", [&out](const CLI::App& command, const std::string& path) {
        if (!path.empty()) {
            out += man_of_command(command, path);
        }
    });
    return out +
           ".SH EXIT STATUS\n.TP\n.B 0\nGood.\n.TP\n.B 1\nA verdict or comparison failed, or "
           "there is no such session, account or entity.\n.TP\n.B 2\nBad usage or config.\n.TP\n"
           ".B 3\nThe environment: a port in use, no such file, no answer.\n.SH FILES\n.TP\n"
           ".I session.state_folder\nCertificate, admin token, files of crashes, and store.db: "
           "accounts, characters, bans, used tickets, durable events.\n";
}

}  // namespace zoned::app
