// palpate for C#: the functions of palpate.h, and a disposable contact. For Unity, put this file and the shared
// library of the platform below Assets/Plugins. docs/integrate/unity.md
//
// License: MIT OR Apache-2.0
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Palpate
{
    /// <summary>An invalid parameter; the message states its name, its value and the allowed range.</summary>
    public sealed class ParameterException : Exception
    {
        public ParameterException(string message) : base(message) { }
    }

    public enum Side : uint { Positive = 0, Negative = 1 }

    public enum Phase : uint { Free = 0, Contact = 1, Enters = 2, Leaves = 3, Waiting = 4 }

    public enum Fault : uint
    {
        None = 0,
        PositionNotFinite = 1,
        VirtualForceNotFinite = 2,
        ElapsedNotPositive = 3,
        GapTooLong = 4,
        JumpTooFast = 5,
        Overflow = 6,
        OrientationNotUnit = 7,
        Other = 99,
        Argument = 100,
        Internal = 101,
    }

    /// <summary>palpate_hold: what the actuator holds for each command.</summary>
    public enum Hold : uint
    {
        Constant = 0,
        Line = 1,
    }

    /// <summary>palpate_loop_params. <see cref="Default"/> fills it.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct LoopParams
    {
        internal UIntPtr StructSize;
        /// <summary>[s]</summary>
        public double Period;
        public double LargestGap;
        public double SpeedLimit;
        /// <summary>[N]</summary>
        public double ForceLimit;
        public double SlewLimit;
        public double Delay;
        public double DelayDeviation;
        public double Lag;
        public double LagDeviation;
        public double Gain;
        public double GainDeviation;
        /// <summary>[kg]</summary>
        public double DeviceMass;
        public double EncoderQuantum;
        public double GuardSpeed;
        public double GuardAllowance;
        public double GuardAcceleration;
        public double GuardHandForce;
        public double GuardMass;
        public double GuardRecovery;
        public uint Guard;
        public Hold Hold;
        public uint GuardLearnsMass;
        internal uint Reserved;

        /// <summary>Returns the default parameters with a period [s].</summary>
        public static LoopParams Default(double period)
        {
            LoopParams loop;
            Contact.Check(Native.palpate_loop_params_init(out loop, (UIntPtr)Marshal.SizeOf(typeof(LoopParams))));
            loop.Period = period;
            return loop;
        }
    }

    /// <summary>palpate_contact_params. <see cref="Default"/> fills it.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct ContactParams
    {
        internal UIntPtr StructSize;
        /// <summary>[N/m]</summary>
        public double Stiffness;
        /// <summary>[kg]; infinite: a wall</summary>
        public double ObjectMass;
        /// <summary>[m]</summary>
        public double ObjectPosition;
        /// <summary>[m/s]</summary>
        public double ObjectVelocity;
        /// <summary>[N]</summary>
        public double VirtualForce;
        internal IntPtr Method;
        internal IntPtr Settings;
        internal UIntPtr SettingCount;
        public Side Side;
        public uint Unilateral;

        /// <summary>Returns the default parameters with a stiffness [N/m].</summary>
        public static ContactParams Default(double stiffness)
        {
            ContactParams contact;
            Contact.Check(
                Native.palpate_contact_params_init(out contact, (UIntPtr)Marshal.SizeOf(typeof(ContactParams))));
            contact.Stiffness = stiffness;
            return contact;
        }
    }

    /// <summary>A method setting by its key in files, with a number in the unit of the key or a word; a switch
    /// accepts "true" and "false".</summary>
    public struct Setting
    {
        public readonly string Key;
        public readonly double Number;
        public readonly string Word;

        public Setting(string key, double number)
        {
            Key = key;
            Number = number;
            Word = null;
        }

        public Setting(string key, string word)
        {
            Key = key;
            Number = 0.0;
            Word = word;
        }
    }

    /// <summary>palpate_setting.</summary>
    [StructLayout(LayoutKind.Sequential)]
    struct NativeSetting
    {
        internal IntPtr Key;
        internal double Number;
        internal IntPtr Word;
    }

    /// <summary>palpate_sample.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Sample
    {
        internal UIntPtr StructSize;
        public double DevicePosition;
        public double Elapsed;
        public double VirtualForce;
        public uint HasElapsed;
        internal uint Reserved;

        /// <summary>Returns a sample at a position [m], one period after the previous one.</summary>
        public static Sample At(double devicePosition)
        {
            return new Sample
            {
                StructSize = (UIntPtr)SizeOf,
                DevicePosition = devicePosition,
            };
        }

        static readonly int SizeOf = Marshal.SizeOf(typeof(Sample));
    }

    /// <summary>palpate_output.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Output
    {
        internal UIntPtr StructSize;
        public double ForceOnDevice;
        public double ForceOnObject;
        /// <summary>[N/s]; 0 unless the loop has <see cref="Hold.Line"/></summary>
        public double SlopeOnDevice;
        public double ObjectPosition;
        public double ObjectVelocity;
        public double Penetration;
        public double TransitionAfter;
        public double ProxyShift;
        public Phase Phase;
        public Fault Fault;
        public uint Limited;
        internal uint Reserved;

        internal static readonly UIntPtr SizeOf = (UIntPtr)Marshal.SizeOf(typeof(Output));
    }

    static class Native
    {
        const string Library = "palpate";

        [DllImport(Library)] internal static extern uint palpate_abi_version();
        [DllImport(Library)] internal static extern IntPtr palpate_last_error();
        [DllImport(Library)] internal static extern uint palpate_loop_params_init(out LoopParams loop, UIntPtr size);
        [DllImport(Library)] internal static extern uint palpate_contact_params_init(
            out ContactParams contact, UIntPtr size);
        [DllImport(Library)] internal static extern uint palpate_contact_new(
            ref ContactParams contact, ref LoopParams loop, out IntPtr handle);
        [DllImport(Library)] internal static extern uint palpate_contact_change(
            IntPtr handle, ref ContactParams contact, ref LoopParams loop);
        [DllImport(Library)] internal static extern uint palpate_contact_report_sent(IntPtr handle, double force);
        [DllImport(Library)] internal static extern uint palpate_contact_report_sent_line(
            IntPtr handle, double force, double slope);
        [DllImport(Library)] internal static extern double palpate_contact_step(
            IntPtr handle, ref Sample sample, ref Output output);
        [DllImport(Library)] internal static extern void palpate_contact_free(IntPtr handle);
    }

    /// <summary>A rendered contact. Only one thread may use it at a time.</summary>
    public sealed class Contact : IDisposable
    {
        const uint AbiVersion = 1;
        IntPtr handle;
        bool holdsLines;

        /// <summary>Creates a contact. Default method: coupled rendering. A missing setting has its default.</summary>
        /// <exception cref="ParameterException">A parameter is outside its range, or the method has no such
        /// setting.</exception>
        public Contact(ContactParams contact, LoopParams loop, string method = null, params Setting[] settings)
        {
            if (Native.palpate_abi_version() != AbiVersion)
            {
                throw new ParameterException("Palpate.cs and the library palpate have different interface versions");
            }
            WithMethod(contact, method, settings, given => Native.palpate_contact_new(ref given, ref loop, out handle));
            holdsLines = loop.Hold == Hold.Line;
        }

        /// <summary>Executes one tick: returns the force on the device [N] for its position [m]. It does not throw
        /// before Dispose and does not allocate managed memory.</summary>
        /// <exception cref="InvalidOperationException">The loop has <see cref="Hold.Line"/>.</exception>
        public double Step(double devicePosition)
        {
            if (holdsLines)
            {
                throw new InvalidOperationException(
                    "the output has the slope of the line: call Step(sample, out output)");
            }
            Output output;
            return Step(Sample.At(devicePosition), out output);
        }

        /// <summary>Executes one tick and returns the full output.</summary>
        public double Step(Sample sample, out Output output)
        {
            output = new Output { StructSize = Output.SizeOf };
            return Native.palpate_contact_step(handle, ref sample, ref output);
        }

        /// <summary>Reports the force that was actually sent to the device for the last tick [N].</summary>
        public void ReportSent(double forceOnDevice)
        {
            Native.palpate_contact_report_sent(handle, forceOnDevice);
        }

        /// <summary>Reports the line that was actually sent to the device for the last tick: its mean [N] and its
        /// slope [N/s].</summary>
        public void ReportSentLine(double forceOnDevice, double slopeOnDevice)
        {
            Native.palpate_contact_report_sent_line(handle, forceOnDevice, slopeOnDevice);
        }

        /// <summary>Changes the rendering from the next tick on, without a step in the force. Call it in the thread
        /// of the ticks.</summary> <exception cref="ParameterException">A parameter is outside its range, or the
        /// method has no such setting.</exception>
        public void Change(ContactParams contact, LoopParams loop, string method = null, params Setting[] settings)
        {
            WithMethod(contact, method, settings, given => Native.palpate_contact_change(handle, ref given, ref loop));
            holdsLines = loop.Hold == Hold.Line;
        }

        public void Dispose()
        {
            Native.palpate_contact_free(handle);
            handle = IntPtr.Zero;
            GC.SuppressFinalize(this);
        }

        ~Contact()
        {
            Dispose();
        }

        static void WithMethod(
            ContactParams contact, string method, Setting[] settings, Func<ContactParams, uint> call)
        {
            var native = new NativeSetting[settings.Length];
            GCHandle pinned = GCHandle.Alloc(native, GCHandleType.Pinned);
            try
            {
                contact.Method = TextOf(method);
                for (int at = 0; at < settings.Length; at++)
                {
                    native[at].Key = TextOf(settings[at].Key);
                    native[at].Number = settings[at].Number;
                    native[at].Word = TextOf(settings[at].Word);
                }
                contact.Settings = pinned.AddrOfPinnedObject();
                contact.SettingCount = (UIntPtr)settings.Length;
                Check(call(contact));
            }
            finally
            {
                // The library has copied the texts.
                Marshal.FreeHGlobal(contact.Method);
                foreach (NativeSetting setting in native)
                {
                    Marshal.FreeHGlobal(setting.Key);
                    Marshal.FreeHGlobal(setting.Word);
                }
                pinned.Free();
            }
        }

        /// Returns a zero-terminated UTF-8 copy of a text in unmanaged memory, or zero for null.
        static IntPtr TextOf(string text)
        {
            if (text == null)
            {
                return IntPtr.Zero;
            }
            byte[] bytes = Encoding.UTF8.GetBytes(text + "\0");
            IntPtr memory = Marshal.AllocHGlobal(bytes.Length);
            Marshal.Copy(bytes, 0, memory, bytes.Length);
            return memory;
        }

        internal static void Check(uint status)
        {
            if (status != 0)
            {
                throw new ParameterException(Marshal.PtrToStringAnsi(Native.palpate_last_error()));
            }
        }
    }
}
