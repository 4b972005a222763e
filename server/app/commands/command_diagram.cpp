#include "server/ai/agent/brain/sense_names.h"
#include "server/ai/decision/state_machine/state_diagram.h"
#include "server/app/commands/commands.h"
#include "server/app/commands/config_loading.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

namespace zoned::app {

namespace {

bool write_all(int file, const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
        const ssize_t n = ::write(file, text.data() + done, text.size() - done);
        if (n <= 0) {
            return false;
        }
        done += static_cast<std::size_t>(n);
    }
    return true;
}

/// Runs `dot -Tsvg -o FILE` on the text. 127: there is no such program.
int run_graphviz(const std::string& text, const std::string& svg) {
    int ends[2] = {};
    if (::pipe(ends) != 0) {
        return 1;
    }
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(ends[0], STDIN_FILENO);
        ::close(ends[0]);
        ::close(ends[1]);
        ::execlp("dot", "dot", "-Tsvg", "-o", svg.c_str(), static_cast<char*>(nullptr));
        ::_exit(127);
    }
    ::close(ends[0]);
    // A program that is not there does not read.
    const auto before = std::signal(SIGPIPE, SIG_IGN);
    const bool written = child > 0 && write_all(ends[1], text);
    ::close(ends[1]);
    std::signal(SIGPIPE, before);
    int status = 0;
    if (child < 0 || ::waitpid(child, &status, 0) != child || !WIFEXITED(status)) {
        return 1;
    }
    return WEXITSTATUS(status) != 0 ? WEXITSTATUS(status) : written ? 0 : 1;
}

}  // namespace

int explain_diagram(const ExplainArguments& arguments) {
    config::Settings settings;
    if (!load_or_complain(arguments.config, arguments.sets, settings)) {
        return kUsage;
    }
    std::string known;
    for (const ai::Brain& brain : settings.ai.brains) {
        known += (known.empty() ? "'" : ", '") + brain.name + "'";
        if (brain.name != arguments.diagram) {
            continue;
        }
        const std::string text =
            ai::state_machine::dot_of(ai::state_machine_of(brain), ai::sense_names(brain));
        if (arguments.svg.empty()) {
            std::fputs(text.c_str(), stdout);
            return kGood;
        }
        const int status = run_graphviz(text, arguments.svg);
        if (status == 127) {
            std::fprintf(stderr,
                         "zoned: cannot run 'dot'; install graphviz, or leave --svg out and have "
                         "the diagram as text\n");
            return kEnvironment;
        }
        if (status != 0) {
            std::fprintf(stderr, "zoned: dot could not write %s\n", arguments.svg.c_str());
            return kEnvironment;
        }
        return kGood;
    }
    std::fprintf(stderr,
                 "zoned: %s has no brain named '%s'; it has %s\n",
                 arguments.config.c_str(),
                 arguments.diagram.c_str(),
                 known.empty() ? "none" : known.c_str());
    return kUsage;
}

}  // namespace zoned::app
