/* A library with functions of Force Dimension's interface, for an emulated device in another process or thread. Each call
 * is a question over a Unix socket. PALPATE_SOCKET is its path. No code or header of the manufacturer is used. */
#include <fcntl.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#ifndef MSG_NOSIGNAL
#define MSG_NOSIGNAL 0
#endif

enum { VALUES = 36 };

typedef struct {
    int32_t what, number;
    double values[8];
} Question;

typedef struct {
    int32_t result, unused;
    double values[VALUES];
} Answer;

/* Questions, by the numbers of `protocol.rs`. */
enum {
    AVAILABLE, OPEN, CLOSE, STOP, TYPE, STATUS, ENABLE, POSITION, VELOCITY, FRAME, COMMAND, GAP, GRAVITY, LIMITS, BRAKES,
    SET_WATCHDOG, WATCHDOG, JOINTS, INERTIA, BUTTONS, ANGULAR_VELOCITY, EFFECTOR
};

static int line = -1;
static const char *trouble = "no error";

static int connected(void) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (line >= 0) {
        return 1;
    }
    strncpy(address.sun_path, PALPATE_SOCKET, sizeof address.sun_path - 1);
    line = socket(AF_UNIX, SOCK_STREAM, 0);
    if (line >= 0 && fcntl(line, F_SETFD, FD_CLOEXEC) == 0 && connect(line, (struct sockaddr *)&address, sizeof address) == 0) {
        return 1;
    }
    close(line);
    line = -1;
    return 0;
}

static int whole(int is_read, void *bytes, size_t size) {
    size_t done = 0;
    while (done < size) {
        ssize_t part = is_read ? read(line, (char *)bytes + done, size - done)
                               : send(line, (char *)bytes + done, size - done, MSG_NOSIGNAL);
        if (part <= 0) {
            return 0;
        }
        done += (size_t)part;
    }
    return 1;
}

static int ask(Question question, Answer *answer) {
    memset(answer, 0, sizeof *answer);
    if (!connected()) {
        trouble = "no device found";
        return answer->result = -1;
    }
    if (!whole(0, &question, sizeof question) || !whole(1, answer, sizeof *answer)) {
        close(line);
        line = -1;
        trouble = "communication error";
        return answer->result = -1;
    }
    if (answer->result < 0) {
        trouble = "communication error";
    }
    return answer->result;
}

static int ask_with(int what, int number, const double *values, int count) {
    Question question = {what, number, {0}};
    Answer answer;
    for (int i = 0; i < count; ++i) {
        question.values[i] = values[i];
    }
    return ask(question, &answer);
}

static int ask_for(int what, double *values, int count) {
    Question question = {what, 0, {0}};
    Answer answer;
    int result = ask(question, &answer);
    if (result >= 0) {
        memcpy(values, answer.values, (size_t)count * sizeof *values);
    }
    return result;
}

static int ask_for_three(int what, double *x, double *y, double *z) {
    double values[3] = {0};
    int result = ask_for(what, values, 3);
    *x = values[0], *y = values[1], *z = values[2];
    return result;
}

int dhdGetDeviceCount(void) { return ask_with(AVAILABLE, 0, 0, 0); }
int dhdGetAvailableCount(void) { return ask_with(AVAILABLE, 0, 0, 0); }
int dhdOpenID(char id) { return ask_with(OPEN, -1 - id, 0, 0); }
int dhdOpen(void) { return dhdOpenID(0); }
int dhdOpenSerial(int serial) { return ask_with(OPEN, serial, 0, 0); }

int dhdClose(char id) {
    int result = ask_with(CLOSE, id, 0, 0);
    close(line);
    line = -1;
    return result;
}

int dhdStop(char id) { return ask_with(STOP, id, 0, 0); }
int dhdGetSystemType(char id) { return ask_with(TYPE, id, 0, 0); }
const char *dhdGetSystemName(char id) { return (void)id, "emulated by palpate"; }
int dhdErrorGetLast(void) { return 2; }
const char *dhdErrorGetLastStr(void) { return trouble; }
int dhdEnableExpertMode(void) { return 0; }

int dhdGetStatus(int *status, char id) {
    double values[17];
    int result = ask_for(STATUS, values, 17);
    (void)id;
    for (int i = 0; result >= 0 && i < 17; ++i) {
        status[i] = (int)values[i];
    }
    return result;
}

int dhdEnableForce(bool on, char id) { return (void)id, ask_with(ENABLE, on, 0, 0); }
int dhdSetGravityCompensation(bool on, char id) { return (void)id, ask_with(GRAVITY, on, 0, 0); }
int dhdSetBrakes(bool on, char id) { return (void)id, ask_with(BRAKES, on, 0, 0); }
int dhdSetMaxForce(double limit, char id) { return (void)id, ask_with(LIMITS, 0, &limit, 1); }
int dhdSetMaxTorque(double limit, char id) { return (void)id, ask_with(LIMITS, 1, &limit, 1); }
int dhdGetPosition(double *x, double *y, double *z, char id) { return (void)id, ask_for_three(POSITION, x, y, z); }

int dhdGetLinearVelocity(double *x, double *y, double *z, char id) {
    return (void)id, ask_for_three(VELOCITY, x, y, z);
}

int dhdGetAngularVelocityRad(double *x, double *y, double *z, char id) {
    return (void)id, ask_for_three(ANGULAR_VELOCITY, x, y, z);
}

int dhdGetPositionAndOrientationFrame(double *x, double *y, double *z, double frame[3][3], char id) {
    double values[12] = {0};
    int result = ask_for(FRAME, values, 12);
    (void)id;
    *x = values[0], *y = values[1], *z = values[2];
    memcpy(frame, values + 3, 9 * sizeof *values);
    return result;
}

int dhdSetForceAndTorqueAndGripperForce(
    double x, double y, double z, double a, double b, double c, double grip, char id) {
    const double values[7] = {x, y, z, a, b, c, grip};
    return (void)id, ask_with(COMMAND, 0, values, 7);
}

int dhdSetForceAndTorque(double x, double y, double z, double a, double b, double c, char id) {
    return dhdSetForceAndTorqueAndGripperForce(x, y, z, a, b, c, 0.0, id);
}

int dhdSetForce(double x, double y, double z, char id) {
    return dhdSetForceAndTorque(x, y, z, 0.0, 0.0, 0.0, id);
}

int dhdGetGripperGap(double *gap, char id) { return (void)id, ask_for(GAP, gap, 1); }
unsigned dhdGetButtonMask(char id) { return (void)id, (unsigned)ask_with(BUTTONS, 0, 0, 0); }
double dhdGetComFreq(char id) { return (void)id, 4.0; }
int dhdSetWatchdog(unsigned char number, char id) { return (void)id, ask_with(SET_WATCHDOG, number, 0, 0); }

int dhdGetWatchdog(unsigned char *number, char id) {
    double value = 0.0;
    int result = ask_for(WATCHDOG, &value, 1);
    (void)id;
    *number = (unsigned char)value;
    return result;
}

int dhdGetJointAngles(double joints[8], char id) { return (void)id, ask_for(JOINTS, joints, 8); }
int dhdGetEffectorMass(double *mass, char id) { return (void)id, ask_for(EFFECTOR, mass, 1); }

int dhdJointAnglesToInertiaMatrix(double joints[8], double matrix[6][6], char id) {
    Question question = {INERTIA, id, {0}};
    Answer answer;
    memcpy(question.values, joints, sizeof question.values);
    if (ask(question, &answer) >= 0) {
        memcpy(matrix, answer.values, 36 * sizeof(double));
    }
    return answer.result;
}
