#include "server/app/commands/commands.h"
#include "server/app/commands/game_templates.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

namespace zoned::app {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 40;

/// Fit for a program, a CMake project, an image and a world: [a-z][a-z0-9_]*.
bool is_good_name(std::string_view name) {
    const auto is_letter = [](char c) {
        return c >= 'a' && c <= 'z';
    };
    return !name.empty() && name.size() <= kLongestName && is_letter(name.front()) &&
           std::all_of(name.begin(), name.end(), [&](char c) {
               return is_letter(c) || (c >= '0' && c <= '9') || c == '_';
           });
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
    for (std::size_t at = text.find(from); at != std::string::npos;
         at = text.find(from, at + to.size())) {
        text.replace(at, from.size(), to);
    }
}

/// The world that comes with the server, with the game's name, port and script.
std::string world_of(std::string text, const NewArguments& arguments) {
    const std::size_t world = text.find("world {");
    text.erase(0, world);
    replace_all(text, "name: \"minimal\"", "name: \"" + arguments.name + "\"");
    replace_all(
        text,
        "  name: \"player\"",
        "  field { name: \"tags\" number { max: 1000 } }   # the rules count, clients see it\n"
        "  name: \"player\"");
    text.insert(0,
                "# The world of " + arguments.name +
                    ": one zone, some crates, two NPCs. The folder proto/config of zoned explains "
                    "every setting.\n\n");
    text += "network { tcp_port: 7777 udp_port: 7778 }\n";
    return text + (arguments.lua ? "script { file: \"game.lua\" }\n" : "");
}

void write(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.close();
    if (!out) {
        throw std::system_error(errno, std::generic_category(), "cannot write " + path.string());
    }
    if (path.extension() == ".sh") {
        using enum fs::perms;
        fs::permissions(path, owner_exec | group_exec | others_exec, fs::perm_options::add);
    }
}

/// The variable by which a game's scripts find this server where it is not installed in a usual
/// place: its programs for games in Lua, its CMake package for others. Empty: none is needed.
struct Variable {
    std::string name;
    std::string value;
    std::string_view more;  ///< what a shell adds
};

Variable variable_for(bool lua) {
    const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
    const fs::path prefix = folder.parent_path();
    if (prefix == "/usr" || prefix == "/usr/local") {
        return {};
    }
    if (lua) {
        return {"PATH", folder.string(), ":$PATH"};
    }
    return fs::exists(folder / "zoned-config.cmake")
               ? Variable{"zoned_DIR", folder.string(), ""}
               : Variable{"CMAKE_PREFIX_PATH", prefix.string(), ""};
}

void tell_next_steps(const NewArguments& arguments, const Variable& variable) {
    std::printf(
        "%s holds a game of %s; its README.md says what each file is.\n"
        "  cd %s\n",
        arguments.folder.c_str(),
        arguments.game == "tag" ? "tag" : "capture the flag",
        arguments.folder.c_str());
    if (!variable.name.empty()) {
        std::printf("  export %s=%s%s\n",
                    variable.name.c_str(),
                    variable.value.c_str(),
                    variable.more.data());
    }
    std::printf(
        "  ./test.sh   # %s\n"
        "  ./run.sh    # its server, until Ctrl-C\n",
        arguments.lua ? "bots play it and give their verdict" : "builds it and runs its tests");
}

/// This process goes on as the game's test.
int run_test(const fs::path& folder, const Variable& variable) {
    if (!variable.name.empty()) {
        const char* path = std::getenv("PATH");
        const bool adds = !variable.more.empty() && path != nullptr;
        setenv(variable.name.c_str(),
               (variable.value + (adds ? ":" : "") + (adds ? path : "")).c_str(),
               1);
    }
    std::fflush(stdout);
    const std::string script = (folder / "test.sh").string();
    execl(script.c_str(), script.c_str(), static_cast<char*>(nullptr));
    throw std::system_error(errno, std::generic_category(), "cannot run " + script);
}

}  // namespace

int new_game(NewArguments arguments) {
    const fs::path folder = fs::absolute(arguments.folder).lexically_normal();
    if (arguments.name.empty()) {
        arguments.name = (folder.has_filename() ? folder : folder.parent_path()).filename();
    }
    if (!is_good_name(arguments.name)) {
        std::fprintf(stderr,
                     "zoned: \"%s\" is no name for a game: small letters, digits and _ are, up to "
                     "%zu, a letter first; choose one with --name\n",
                     arguments.name.c_str(),
                     kLongestName);
        return kUsage;
    }
    if (fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder))) {
        std::fprintf(stderr,
                     "zoned: %s is there already and not an empty folder: nothing was written\n",
                     folder.c_str());
        return kUsage;
    }
    const bool is_capture = arguments.game == "capture_the_flag";
    if (is_capture && arguments.lua) {
        std::fputs("zoned: capture_the_flag is in C++: leave --lua out\n", stderr);
        return kUsage;
    }
    const NewGame game = is_capture      ? NewGame::kCaptureTheFlag
                         : arguments.lua ? NewGame::kLua
                                         : NewGame::kCpp;
    for (const GameTemplate& file : game_templates()) {
        if (file.game == game) {
            const bool is_world = !is_capture && std::string_view(file.path) == "world.txtpb";
            std::string text = is_world ? world_of(file.text, arguments) : file.text;
            replace_all(text, "@GAME@", arguments.name);
            write(folder / file.path, text);
        }
    }
    const Variable variable = variable_for(arguments.lua);
    tell_next_steps(arguments, variable);
    return arguments.test ? run_test(folder, variable) : kGood;
}

}  // namespace zoned::app
