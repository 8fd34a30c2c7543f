/* Landlock and seccomp by their system calls: the headers of older systems lack parts of the first, and the second is a
 * program of few instructions. */
#include "platform/seal.h"

#include "common/util.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#ifdef __linux__
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <stddef.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
#endif

/* The checkers of memory start threads of their own, stop each other and read /proc at the end. */
static const char *obstacle(void)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return "this build has a sanitizer, which needs what the sandbox takes away";
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
    return "this build has a sanitizer, which needs what the sandbox takes away";
#endif
#endif
#ifdef __linux__
    return NULL;
#else
    return "only Linux has Landlock and seccomp";
#endif
}

#ifdef __linux__

/* ---- Landlock: Documentation/userspace-api/landlock.rst of the kernel ---- */

enum { CREATE_RULESET = 444, ADD_RULE = 445, RESTRICT_SELF = 446, VERSION_FLAG = 1, PATH_BENEATH = 1, TSYNC = 8 };

enum {
    FS_EXECUTE = 1 << 0,
    FS_WRITE_FILE = 1 << 1,
    FS_READ_FILE = 1 << 2,
    FS_READ_DIR = 1 << 3,
    FS_REMOVE_FILE = 1 << 5,
    FS_MAKE_REG = 1 << 8,
    FS_TRUNCATE = 1 << 14,
    FS_FIRST = (1 << 13) - 1, /* all of version 1; each of the versions 2, 3 and 5 adds one */
    FS_OF_FILES = FS_EXECUTE | FS_WRITE_FILE | FS_READ_FILE | FS_TRUNCATE,
    NET_TCP = 3,       /* bind and connect: version 4 */
    SCOPE_ABSTRACT = 1 /* abstract sockets of others: version 6 */
};

typedef struct ruleset_attr {
    uint64_t fs, net, scoped;
} ruleset_attr;

typedef struct __attribute__((packed)) beneath_attr {
    uint64_t allowed;
    int32_t folder;
} beneath_attr;

static int landlock_version(void)
{
    long version = syscall(CREATE_RULESET, NULL, (size_t)0, VERSION_FLAG);
    return version > 0 ? (int)version : 0;
}

static ruleset_attr what_is_handled(int version)
{
    ruleset_attr out = {.fs = FS_FIRST};
    if (version >= 2) out.fs |= 1 << 13;
    if (version >= 3) out.fs |= FS_TRUNCATE;
    if (version >= 4) out.net = NET_TCP;
    if (version >= 5) out.fs |= 1 << 15;
    if (version >= 6) out.scoped = SCOPE_ABSTRACT;
    return out;
}

/* Versions take a struct of their own length. */
static size_t attr_size(int version) { return version >= 6 ? 24 : version >= 4 ? 16 : 8; }

static void allow(int rules, const char *path, uint64_t rights)
{
    struct stat status;
    int file = path ? open(path, O_PATH | O_CLOEXEC) : -1;
    if (file < 0) return;
    if (fstat(file, &status) == 0) {
        if (!S_ISDIR(status.st_mode)) rights &= FS_OF_FILES;
        beneath_attr rule = {rights, file};
        if (rights) syscall(ADD_RULE, rules, PATH_BENEATH, &rule, 0);
    }
    close(file);
}

static void allow_all(int rules, const seal_def *def, uint64_t handled)
{
    /* Libraries that are loaded when they are first needed: Assimp, drivers, codecs. */
    static const char *const LIBRARIES[] = {"/usr/lib",   "/usr/lib64",      "/lib", "/lib64", "/usr/local/lib",
                                            "/nix/store", "/etc/ld.so.cache"};
    /* Cursors, fonts and keyboard layouts; gamepads that are plugged in later. */
    static const char *const SYSTEM[] = {"/usr/share", "/dev/urandom",     "/dev/input",
                                         "/run/udev",  "/sys/class/input", "/sys/devices"};
    const uint64_t reads = FS_READ_FILE | FS_READ_DIR;
    const uint64_t writes = FS_WRITE_FILE | FS_READ_DIR | FS_REMOVE_FILE | FS_MAKE_REG | (FS_TRUNCATE & handled);
    for (size_t i = 0; i < SEAL_PATHS; i++) {
        allow(rules, def->readable[i], reads);
        allow(rules, def->writable[i], writes);
    }
    for (size_t i = 0; i < COUNT_OF(LIBRARIES); i++) allow(rules, LIBRARIES[i], reads);
    for (size_t i = 0; def->window && i < COUNT_OF(SYSTEM); i++) allow(rules, SYSTEM[i], reads);
    allow(rules, "/dev/null", FS_READ_FILE | FS_WRITE_FILE);
}

static bool set_landlock(const seal_def *def, daft_error *error)
{
    int version = landlock_version();
    if (version == 0) return true;
    ruleset_attr attr = what_is_handled(version);
    int rules = (int)syscall(CREATE_RULESET, &attr, attr_size(version), 0);
    if (rules < 0) return fail(error, DAFT_ERROR_UNSUPPORTED, "Landlock: %s", strerror(errno));
    allow_all(rules, def, attr.fs);
    bool good = version >= 8 && syscall(RESTRICT_SELF, rules, TSYNC) == 0;
    if (!good) good = syscall(RESTRICT_SELF, rules, 0) == 0;
    if (!good) fail(error, DAFT_ERROR_UNSUPPORTED, "Landlock: %s", strerror(errno));
    close(rules);
    return good;
}

/* ---- seccomp ---- */

#if defined(__x86_64__)
#define NATIVE_ARCH AUDIT_ARCH_X86_64
#elif defined(__aarch64__) && !defined(__ARM_BIG_ENDIAN)
#define NATIVE_ARCH AUDIT_ARCH_AARCH64
#elif defined(__riscv) && __riscv_xlen == 64
#define NATIVE_ARCH AUDIT_ARCH_RISCV64
#endif

#ifdef NATIVE_ARCH

/* Calls that fail with EPERM. */
static const int DENIED[] = {
    /* programs and processes */
    SYS_execve, SYS_execveat, SYS_unshare, SYS_setns,
#ifdef SYS_fork
    SYS_fork, SYS_vfork,
#endif
    /* other processes */
    SYS_ptrace, SYS_process_vm_readv, SYS_process_vm_writev, SYS_kcmp, SYS_tkill, SYS_migrate_pages, SYS_move_pages,
#ifdef SYS_pidfd_open
    SYS_pidfd_open, SYS_pidfd_send_signal,
#endif
#ifdef SYS_pidfd_getfd
    SYS_pidfd_getfd,
#endif
#ifdef SYS_process_madvise
    SYS_process_madvise,
#endif
    /* the network; connections that stand, as the one to the display, stay */
    SYS_socket, SYS_connect, SYS_bind, SYS_listen, SYS_accept, SYS_accept4,
    /* what reaches deep into the kernel */
    SYS_bpf, SYS_perf_event_open, SYS_userfaultfd, SYS_add_key, SYS_request_key, SYS_keyctl, SYS_kexec_load,
    SYS_init_module, SYS_finit_module, SYS_delete_module, SYS_acct, SYS_reboot, SYS_swapon, SYS_swapoff, SYS_quotactl,
    SYS_syslog, SYS_personality, SYS_open_by_handle_at, SYS_name_to_handle_at, SYS_fanotify_init, SYS_lookup_dcookie,
#ifdef SYS_io_uring_setup
    SYS_io_uring_setup, SYS_io_uring_enter, SYS_io_uring_register,
#endif
#ifdef SYS_kexec_file_load
    SYS_kexec_file_load,
#endif
#ifdef SYS_iopl
    SYS_iopl, SYS_ioperm, SYS_modify_ldt,
#endif
    /* file systems, names of the machine, the clock */
    SYS_mount, SYS_umount2, SYS_pivot_root, SYS_chroot, SYS_sethostname, SYS_setdomainname, SYS_settimeofday,
    SYS_clock_settime, SYS_clock_adjtime, SYS_adjtimex, SYS_mknodat, SYS_linkat, SYS_symlinkat, SYS_fchownat,
#ifdef SYS_mknod
    SYS_mknod, SYS_link, SYS_symlink, SYS_chown, SYS_lchown,
#endif
#ifdef SYS_open_tree
    SYS_open_tree, SYS_move_mount, SYS_fsopen, SYS_fsconfig, SYS_fsmount, SYS_fspick,
#endif
#ifdef SYS_mount_setattr
    SYS_mount_setattr,
#endif
    /* who the process is */
    SYS_setuid, SYS_setgid, SYS_setreuid, SYS_setregid, SYS_setresuid, SYS_setresgid, SYS_setgroups, SYS_setfsuid,
    SYS_setfsgid, SYS_capset};

enum { FILTER_SIZE = 2 * COUNT_OF(DENIED) + 64 };

typedef struct filter {
    struct sock_filter code[FILTER_SIZE];
    unsigned short count;
} filter;

static void put(filter *f, int code, uint32_t value, uint8_t if_true, uint8_t if_false)
{
    f->code[f->count++] = (struct sock_filter){(uint16_t)code, if_true, if_false, value};
}

static void put_load(filter *f, size_t offset) { put(f, BPF_LD | BPF_W | BPF_ABS, (uint32_t)offset, 0, 0); }
static void put_answer(filter *f, uint32_t answer) { put(f, BPF_RET | BPF_K, answer, 0, 0); }
static void put_refusal(filter *f, int number) { put_answer(f, SECCOMP_RET_ERRNO | (uint32_t)number); }
static void put_equal(filter *f, uint32_t value, uint8_t if_true, uint8_t if_false)
{
    put(f, BPF_JMP | BPF_JEQ | BPF_K, value, if_true, if_false);
}

/* The low half of an argument: the first four bytes, as all machines above are little-endian. */
static size_t argument(int index) { return offsetof(struct seccomp_data, args) + 8 * (size_t)index; }

/* `call` is refused unless its first argument is this process. */
static void put_own_process(filter *f, long call, uint32_t process)
{
    put_equal(f, (uint32_t)call, 0, 4);
    put_load(f, argument(0));
    put_equal(f, process, 0, 1);
    put_answer(f, SECCOMP_RET_ALLOW);
    put_refusal(f, EPERM);
}

static void make_filter(filter *f)
{
    f->count = 0;
    put_load(f, offsetof(struct seccomp_data, arch));
    put_equal(f, NATIVE_ARCH, 1, 0);
    put_refusal(f, EPERM);
    put_load(f, offsetof(struct seccomp_data, nr));
#ifdef __x86_64__
    put(f, BPF_JMP | BPF_JGE | BPF_K, 0x40000000, 0, 1); /* the calls of x32 */
    put_refusal(f, EPERM);
#endif
    for (size_t i = 0; i < COUNT_OF(DENIED); i++) {
        put_equal(f, (uint32_t)DENIED[i], 0, 1);
        put_refusal(f, EPERM);
    }
#ifdef SYS_clone3
    put_equal(f, SYS_clone3, 0, 1); /* its flags lie in memory; libraries then call clone */
    put_refusal(f, ENOSYS);
#endif
    put_equal(f, SYS_clone, 0, 4);
    put_load(f, argument(0));
    put(f, BPF_JMP | BPF_JSET | BPF_K, CLONE_THREAD, 0, 1);
    put_answer(f, SECCOMP_RET_ALLOW);
    put_refusal(f, EPERM);
    put_equal(f, SYS_ioctl, 0, 5); /* what types into the terminal, as if the user did */
    put_load(f, argument(1));
    put_equal(f, TIOCSTI, 1, 0);
    put_equal(f, TIOCLINUX, 0, 1);
    put_refusal(f, EPERM);
    put_answer(f, SECCOMP_RET_ALLOW);
    uint32_t process = (uint32_t)getpid();
    put_own_process(f, SYS_prlimit64, 0); /* 0: itself */
    put_own_process(f, SYS_kill, process);
    put_own_process(f, SYS_tgkill, process);
    put_own_process(f, SYS_rt_sigqueueinfo, process);
    put_own_process(f, SYS_rt_tgsigqueueinfo, process);
    put_answer(f, SECCOMP_RET_ALLOW);
}

static bool has_seccomp(void)
{
    uint32_t action = SECCOMP_RET_ERRNO;
    return syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
}

static bool set_seccomp(daft_error *error)
{
    if (!has_seccomp()) return true;
    filter f;
    make_filter(&f);
    struct sock_fprog program = {f.count, f.code};
    long result = syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program);
    if (result == 0) return true;
    return fail(error, DAFT_ERROR_UNSUPPORTED, "seccomp: %s",
                result > 0 ? "a thread has a filter of its own" : strerror(errno));
}

#else

static bool has_seccomp(void) { return false; }
static bool set_seccomp(daft_error *error) { return (void)error, true; }

#endif

seal_ability seal_look(void)
{
    seal_ability out = {.obstacle = obstacle()};
    out.landlock = landlock_version();
    out.seccomp = has_seccomp();
    return out;
}

bool seal_process(const seal_def *def, daft_error *error)
{
    if (obstacle()) return true;
    tzset(); /* reads a file, once */
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return fail(error, DAFT_ERROR_UNSUPPORTED, "no_new_privs: %s", strerror(errno));
    bool files = set_landlock(def, error);
    return set_seccomp(files ? error : NULL) && files;
}

#else

seal_ability seal_look(void) { return (seal_ability){.obstacle = obstacle()}; }
bool seal_process(const seal_def *def, daft_error *error) { return (void)def, (void)error, true; }

#endif

void seal_print_status(void)
{
    seal_ability has = seal_look();
    printf("loader: on; whatever a game names is read from its own folder, assets/ and scripts/ only\n");
    if (has.landlock && !has.obstacle) {
        printf("Landlock: on, version %d; the process reads the game's files and writes what was asked for\n",
               has.landlock);
        if (has.landlock < 3) printf("  version 3 would also keep files from being cut short\n");
        if (has.landlock < 4) printf("  version 4 would also bar TCP, which seccomp does\n");
    } else {
        printf("Landlock: off; %s\n", has.obstacle ? has.obstacle : "this system has none (Linux 5.13, lsm=landlock)");
    }
    if (has.seccomp && !has.obstacle)
        printf("seccomp: on; no network, no other programs and processes\n");
    else
        printf("seccomp: off; %s\n", has.obstacle ? has.obstacle : "this system has none");
}
