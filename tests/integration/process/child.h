// Child: a program of this build as a child process, with its exit code and output.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace zoned::testing_process {

/// Starts at construction; killed at destruction if it still runs.
class Child {
  public:
    /// `program` is a name within the build folder, or a path from the root. Standard output and
    /// error go to files of the test's own folder.
    Child(const std::string& program, const std::vector<std::string>& arguments);
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Waits until `text` stands in the standard output; false after `seconds` or when the program
    /// ended without it.
    bool wait_for_output(const std::string& text, double seconds);
    /// The same in the standard error, which has the log: its thread may write a line after what
    /// the line tells.
    bool wait_for_errors(const std::string& text, double seconds);
    void signal(int number) const;
    /// Exit code; 128 + signal when a signal ended it; -1 when it still runs after `seconds`.
    int wait(double seconds);

    [[nodiscard]] pid_t pid() const { return pid_; }

    [[nodiscard]] std::string output() const;
    [[nodiscard]] std::string errors() const;

  private:
    bool wait_for_text(std::string (Child::*stream)() const,
                       const std::string& text,
                       double seconds);

    std::string out_file_;
    std::string err_file_;
    pid_t pid_ = -1;
    bool ended_ = false;
    int code_ = -1;
};

/// The number after `key` (such as "tcp=") in a text; -1 when there is none.
int number_after(const std::string& text, const std::string& key);

/// A fresh folder for this test's files.
std::string scratch_folder();

}  // namespace zoned::testing_process
