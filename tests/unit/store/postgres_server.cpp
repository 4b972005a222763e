#include "tests/unit/store/postgres_server.h"

#include <fcntl.h>
#include <pqxx/pqxx>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <thread>

namespace zoned::store::test {

namespace {

/// The newest version that is installed; empty: none.
std::string find_programs() {
    std::string best;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/usr/lib/postgresql", error)) {
        const std::string folder = entry.path() / "bin";
        if (std::filesystem::exists(folder + "/initdb") && folder > best) {
            best = folder;
        }
    }
    return best;
}

}  // namespace

PostgresServer* PostgresServer::get() {
    static const std::unique_ptr<PostgresServer> server = [] {
        std::unique_ptr<PostgresServer> made(new PostgresServer);
        made->programs_ = find_programs();
        if (made->programs_.empty()) {
            return std::unique_ptr<PostgresServer>();
        }
        // The name of a socket may have 107 bytes: not every folder for tests is so short.
        std::string folder = "/tmp/zoned-postgres-XXXXXX";  // as mkdtemp(3) wants it
        if (::mkdtemp(folder.data()) == nullptr) {
            throw std::runtime_error("no folder for PostgreSQL");
        }
        made->folder_ = folder;
        if (::geteuid() == 0) {
            const passwd* user = ::getpwnam("postgres");
            if (user == nullptr || ::chown(folder.c_str(), user->pw_uid, user->pw_gid) != 0) {
                throw std::runtime_error("there is no user postgres");
            }
        }
        int status = -1;
        ::waitpid(made->spawn({"initdb",
                               "--pgdata=" + folder + "/data",
                               "--auth=trust",
                               "--username=tests",
                               "--no-sync",
                               "--encoding=UTF8",
                               "--locale=C"}),
                  &status,
                  0);
        if (status != 0) {
            std::ifstream log(folder + "/log");
            const std::string text((std::istreambuf_iterator<char>(log)), {});
            throw std::runtime_error("initdb ended with " + std::to_string(status) + ": " + text);
        }
        made->start();
        return made;
    }();
    return server.get();
}

PostgresServer::~PostgresServer() {
    if (folder_.empty()) {
        return;
    }
    stop();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

pid_t PostgresServer::spawn(const std::vector<std::string>& command) const {
    const std::string program = programs_ + "/" + command.front();
    const std::string log = folder_ + "/log";
    const passwd* user = ::geteuid() == 0 ? ::getpwnam("postgres") : nullptr;
    // By its whole name it finds the programs beside it, whatever PATH says.
    std::vector<char*> arguments = {const_cast<char*>(program.c_str())};
    for (std::size_t word = 1; word < command.size(); ++word) {
        arguments.push_back(const_cast<char*>(command[word].c_str()));
    }
    arguments.push_back(nullptr);
    const pid_t parent = ::getpid();
    const pid_t child = ::fork();
    if (child != 0) {
        return child;
    }
    if (user != nullptr && (::setgid(user->pw_gid) != 0 || ::setuid(user->pw_uid) != 0)) {
        ::_exit(126);
    }
    // A test that crashes leaves no server behind.
    ::prctl(PR_SET_PDEATHSIG, SIGQUIT);
    const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (::getppid() != parent || out < 0 || ::chdir(folder_.c_str()) != 0) {
        ::_exit(126);
    }
    ::dup2(out, 1);
    ::dup2(out, 2);
    ::execv(program.c_str(), arguments.data());
    ::_exit(127);
}

void PostgresServer::start() {
    server_ = spawn({"postgres",
                     "-D",
                     folder_ + "/data",
                     "-k",
                     folder_,
                     "-c",
                     "listen_addresses=",
                     "-c",
                     "fsync=off"});
    for (int i = 0; i < 600; ++i) {
        try {
            const pqxx::connection connection("host=" + folder_ + " user=tests dbname=postgres");
            return;
        } catch (const pqxx::failure&) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
    }
    throw std::runtime_error("PostgreSQL does not start: " + folder_ + "/log");
}

void PostgresServer::stop() {
    if (server_ > 0) {
        ::kill(server_, SIGQUIT);
        ::waitpid(server_, nullptr, 0);
    }
    server_ = 0;
}

std::string PostgresServer::make_database(const std::string& options) {
    const std::string name = "t" + std::to_string(++databases_);
    pqxx::connection connection("host=" + folder_ + " user=tests dbname=postgres");
    pqxx::nontransaction(connection).exec("CREATE DATABASE " + name + " " + options);
    return "postgresql://tests@/" + name + "?host=" + folder_;
}

}  // namespace zoned::store::test
