#include "src/cli/cli.h"

int main(int argc, char** argv) { return zygoma::run_command_line(argc, argv); }
