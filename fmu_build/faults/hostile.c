/* Attempts on what is not the FMU's. The victim's files are found by HOME, as a thief would. */
#define _GNU_SOURCE
#include "hostile.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/msg.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

enum {
    READ_HOME = 1,
    LIST_HOME,
    WRITE_HOME,
    OVERWRITE_HOME,
    TRUNCATE_HOME,
    DELETE_HOME,
    RENAME_HOME,
    LINK_HOME,
    CHMOD_HOME,
    WRITE_TEMPORARY,
    SHARED_MEMORY_FILE,
    SHARED_MEMORY_SEGMENT,
    MESSAGE_QUEUE,
    TCP,
    UDP,
    TCP6,
    LISTEN,
    LOCAL_SOCKET,
    START_PROGRAM,
    FORK,
    LEAVE_GROUP,
    KILL_GMFBO,
    READ_ENVIRONMENT_OF_GMFBO,
    WRITE_MEMORY_OF_GMFBO,
    TRACE_GMFBO,
    LIMITS_OF_GMFBO,
    SHORTEN_SHARED,
    REMOVE_SHARED,
    LOCK_OF_OWNER,
    LARGE_FILE,
    MANY_FILES,
    RAISE_LIMITS,
    NEW_NAMESPACE,
    RING,
    /* what has to go on working */
    WRITE_OWN = 60,
    THREAD,
    READ_SYSTEM
};

static double result(long answer) { return answer >= 0 ? 1.0 : -(double)errno; }

static const char *at_home(const char *name) {
    static char path[4096];
    const char *home = getenv("HOME");
    snprintf(path, sizeof path, "%s/%s", home ? home : "", name);
    return path;
}

static double open_file(const char *path, int flags) {
    int file = open(path, flags, 0600);
    if (file >= 0) close(file);
    return result(file);
}

/* Leaves nothing behind where it may. */
static double make_file(const char *path) {
    double told = open_file(path, O_CREAT | O_RDWR);
    if (told > 0) unlink(path);
    return told;
}

static double make_segment(void) {
    int segment = shmget(IPC_PRIVATE, 4096, IPC_CREAT | 0600);
    double told = result(segment);
    if (segment >= 0) shmctl(segment, IPC_RMID, NULL);
    return told;
}

static double make_queue(void) {
    int queue = msgget(IPC_PRIVATE, IPC_CREAT | 0600);
    double told = result(queue);
    if (queue >= 0) msgctl(queue, IPC_RMID, NULL);
    return told;
}

/* gmfbo's process: the parent of the keeper, which is this one's parent. */
static pid_t gmfbo(void) {
    char path[64], line[512] = "";
    snprintf(path, sizeof path, "/proc/%d/stat", (int)getppid());
    FILE *file = fopen(path, "r");
    if (!file) return getppid();
    const char *after = fgets(line, sizeof line, file) ? strrchr(line, ')') : NULL;
    fclose(file);
    int parent = getppid();
    if (after) sscanf(after + 1, " %*c %d", &parent);
    return parent;
}

static double connect_to(int family, int type) {
    int sock = socket(family, type, 0);
    if (sock < 0) return -(double)errno;
    const char *port = getenv("GMFBO_TEST_PORT");
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((unsigned short)atoi(port ? port : "9"))};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    long answer = 0;
    if (family == AF_INET && type == SOCK_STREAM)
        answer = connect(sock, (struct sockaddr *)&address, sizeof address);
    if (type == SOCK_DGRAM) answer = sendto(sock, "x", 1, 0, (struct sockaddr *)&address, sizeof address);
    double told = result(answer);
    close(sock);
    return told;
}

static double listen_on_any_port(void) {
    int sock = socket(AF_INET, SOCK_STREAM, 0);
    if (sock < 0) return -(double)errno;
    struct sockaddr_in address = {.sin_family = AF_INET};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    double told = result(bind(sock, (struct sockaddr *)&address, sizeof address));
    close(sock);
    return told;
}

static double start_program(void) {
    pid_t child = fork();
    if (child < 0) return -(double)errno;
    if (child == 0) {
        execl("/bin/sh", "sh", "-c", "exit 7", (char *)NULL);
        _exit(errno & 0x7f);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WEXITSTATUS(status) == 7 ? 1.0 : -(double)WEXITSTATUS(status);
}

/* A child that goes on alone, in a session of its own. */
static double go_on_alone(void) {
    pid_t child = fork();
    if (child == 0) {
        setsid();
        for (;;) sleep(1000);
    }
    return result(child);
}

static double other_process(const char *file, int flags) {
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/%s", (int)gmfbo(), file);
    return open_file(path, flags);
}

/* Files of the private folder, which lies above the working folder. */
static const char *beside(const char *name) {
    static char path[8192];
    char here[4096];
    if (!getcwd(here, sizeof here)) return "";
    snprintf(path, sizeof path, "%s/../%s", here, name);
    return path;
}

/* The file that gmfbo maps too: who shortens it ends gmfbo by SIGBUS. */
static double on_shared(int remove) {
    char line[4096];
    const char *path = NULL;
    FILE *maps = fopen("/proc/self/maps", "r");
    if (!maps) return -(double)errno;
    while (!path && fgets(line, sizeof line, maps))
        if (strstr(line, "/shared/arrays")) path = strchr(line, '/');
    fclose(maps);
    if (!path) return -(double)ENOENT;
    line[strcspn(line, "\n")] = '\0';
    return result(remove ? unlink(path) : truncate(path, 0));
}

static double large_file(void) {
    int file = open("large", O_CREAT | O_WRONLY, 0600);
    if (file < 0) return -(double)errno;
    double told = result(ftruncate(file, (off_t)8 << 30));
    close(file);
    unlink("large");
    return told;
}

static double many_files(void) {
    for (int i = 0; i < 4096; ++i)
        if (open("/dev/null", O_RDONLY) < 0) return -(double)errno;
    return 1.0;
}

static double raise_limits(void) {
    struct rlimit free_of_limits = {RLIM_INFINITY, RLIM_INFINITY};
    return result(setrlimit(RLIMIT_DATA, &free_of_limits));
}

static double limits_of_gmfbo(void) {
    struct rlimit same;
    return result(prlimit(gmfbo(), RLIMIT_CORE, NULL, &same));
}

static void *nothing(void *argument) { return argument; }

static double thread(void) {
    pthread_t made;
    errno = pthread_create(&made, NULL, nothing, NULL);
    if (errno) return -(double)errno;
    return pthread_join(made, NULL) == 0 ? 1.0 : -1.0;
}

static double attempt_on_files(int what) {
    switch (what) {
    case READ_HOME: return open_file(at_home("secret.txt"), O_RDONLY);
    case LIST_HOME: {
        DIR *folder = opendir(at_home(""));
        if (folder) closedir(folder);
        return folder ? 1.0 : -(double)errno;
    }
    case WRITE_HOME: return make_file(at_home("left.txt"));
    case OVERWRITE_HOME: return open_file(at_home("secret.txt"), O_WRONLY);
    case TRUNCATE_HOME: return result(truncate(at_home("secret.txt"), 0));
    case DELETE_HOME: return result(unlink(at_home("secret.txt")));
    case RENAME_HOME: return result(rename(at_home("secret.txt"), "taken.txt"));
    case LINK_HOME: {
        unlink("linked.txt");
        return result(link(at_home("secret.txt"), "linked.txt"));
    }
    case CHMOD_HOME: return result(chmod(at_home("secret.txt"), 0777));
    case WRITE_TEMPORARY: return make_file("/tmp/gmfbo-hostile.txt");
    case SHARED_MEMORY_FILE: return make_file("/dev/shm/gmfbo-hostile");
    case SHORTEN_SHARED: return on_shared(0);
    case REMOVE_SHARED: return on_shared(1);
    case LOCK_OF_OWNER: return open_file(beside("owner.lock"), O_RDWR);
    case LARGE_FILE: return large_file();
    case MANY_FILES: return many_files();
    case WRITE_OWN: return open_file("own.txt", O_CREAT | O_WRONLY | O_TRUNC);
    default: return open_file("/proc/self/maps", O_RDONLY);
    }
}

double attempt(int what) {
    errno = 0;
    switch (what) {
    case 0: return 0.0;
    case SHARED_MEMORY_SEGMENT: return make_segment();
    case MESSAGE_QUEUE: return make_queue();
    case TCP: return connect_to(AF_INET, SOCK_STREAM);
    case UDP: return connect_to(AF_INET, SOCK_DGRAM);
    case TCP6: return connect_to(AF_INET6, SOCK_STREAM);
    case LISTEN: return listen_on_any_port();
    case LOCAL_SOCKET: return connect_to(AF_UNIX, SOCK_STREAM);
    case START_PROGRAM: return start_program();
    case FORK: return go_on_alone();
    case LEAVE_GROUP: return result(setsid());
    case KILL_GMFBO: return result(kill(gmfbo(), 0));
    case READ_ENVIRONMENT_OF_GMFBO: return other_process("environ", O_RDONLY);
    case WRITE_MEMORY_OF_GMFBO: return other_process("mem", O_RDWR);
    case TRACE_GMFBO: return result(ptrace(PTRACE_SEIZE, gmfbo(), NULL, NULL));
    case LIMITS_OF_GMFBO: return limits_of_gmfbo();
    case RAISE_LIMITS: return raise_limits();
    case NEW_NAMESPACE: return result(syscall(SYS_unshare, 0x10000000)); /* CLONE_NEWUSER */
    case RING: return result(syscall(425, 4, NULL)); /* io_uring_setup */
    case THREAD: return thread();
    default: return attempt_on_files(what);
    }
}
